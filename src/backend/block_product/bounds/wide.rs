//! Errors of lobes of any kind.
//!
//! A table has a slice for each cell of the viewer's direction and each family of shapes of blocks. A slice is laid out
//! about the mirror direction m: a block's centre d lies in it at (x, y) sin(θ/2), θ the angle to m and (x, y) the
//! direction from m to d, x along the plane of incidence. So a lobe stays in its place as the viewer moves, and only
//! its shape changes. A slice holds the larger errors of the corners of the viewer's cell and is read off bilinearly.
//! Logarithms of a lobe are concave about its peak, and what lies between two of them that differ by R octaves may be
//! larger than their mean by R/4 (a Gaussian's). They are increased by R²/8, up to the larger one, which with the
//! octave that all errors are increased by is always as much.

use nalgebra::Vector3;

use super::cell_of;
use super::errors::{Checks, Codes, STEPS, code};
use super::gauge::Gauge;
use super::grid::{Grid, LEAST, Symmetry, Viewer, round_square};
use super::lanes::Probe;
use super::lanes::{self, larger};
use crate::backend::block_product::rule::SampleClass;
use crate::backend::block_product::source::LobeSource;
use crate::parallel;
use crate::scene::{Axes, Kernel, KernelVisitor, narrow};

/// The errors of one block: rms, bias and mean of 0, 1, 4 and 16 samples.
type Entry = [[u16; 4]; 3];

const NONE: Entry = [[1; 4]; 3];

/// Errors are measured at single places of the viewer and the block: with twice as much, no error of a whole block at
/// some other place was found above its table (a test).
const MARGIN: f64 = 2.0;

/// The root mean square error of one sample, over that of none, that is rounding.
const EXACT: f32 = 1e-5;

/// Steps between two nodes of a slice.
const FINE: u32 = 8;

/// Errors for each viewer and place, measured.
#[derive(Debug, Clone)]
pub(in crate::backend::block_product) struct WideNodes {
    grid: Grid,
    /// [viewer][family][row][column]
    entries: Vec<Entry>,
}

impl WideNodes {
    /// Measures a lobe.
    pub(in crate::backend::block_product) fn measure(gauge: &Gauge, symmetry: Symmetry, source: &LobeSource) -> Self {
        // Without any symmetry there are too many viewers to tell shapes apart.
        let families = if symmetry == Symmetry::None { &gauge.all } else { &gauge.families };
        let grid = Grid::of(symmetry, families.len(), source.is_opaque());
        let viewer = |node: usize| {
            let viewer = grid.viewer(node);
            let mut entries = vec![NONE; families.len() * grid.plane()];
            let measuring = Measuring { grid, axes: viewer.axes(), gauge, families, entries: &mut entries };
            source.visit(&local_axes(), &viewer.wo(), measuring).expect("no viewer of a grid is below the horizon");
            entries
        };
        let nodes = (grid.elevations + 1) * grid.turns();
        Self { grid, entries: parallel::map(nodes, viewer).concat() }
    }

    /// The larger errors of both.
    ///
    /// # Panics
    /// If they are not of the same symmetry.
    #[track_caller]
    pub(in crate::backend::block_product) fn worse(mut self, other: &Self) -> Self {
        assert_eq!(self.grid, other.grid, "errors of lobes of one kind");
        self.entries.iter_mut().zip(&other.entries).for_each(|(a, b)| *a = worse(*a, *b));
        self
    }
}

/// The frame that kernels are measured in: normal +z, tangent +x.
fn local_axes() -> Axes {
    Axes::new(&crate::scene::LocalFrame { tangent: Vector3::x(), bitangent: Vector3::y(), normal: Vector3::z() })
}

/// All places of one viewer.
struct Measuring<'a> {
    grid: Grid,
    axes: [Vector3<f64>; 3],
    gauge: &'a Gauge,
    families: &'a [Vec<Probe>],
    entries: &'a mut [Entry],
}

impl KernelVisitor for Measuring<'_> {
    type Output = ();

    fn visit<const N: usize, K: Kernel<N>>(self, kernel: K) {
        pulp::Arch::new().dispatch(MeasuringKernel::<N, K> { places: self, kernel });
    }
}

struct MeasuringKernel<'a, const N: usize, K> {
    places: Measuring<'a>,
    kernel: K,
}

impl<const N: usize, K: Kernel<N>> pulp::WithSimd for MeasuringKernel<'_, N, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { kernel, places: Measuring { grid, axes, gauge, families, entries } } = self;
        let mirror = axes[2];
        let peak = kernel.at(narrow(&mirror), mirror.z as f32, mirror.z as f32).into_iter().fold(0.0, larger);
        for (family, entries) in entries.chunks_exact_mut(grid.plane()).enumerate() {
            for (place, entry) in entries.iter_mut().enumerate() {
                let Some((centre, half_sine)) = grid.centre(&axes, place) else { continue };
                if centre.z < -gauge.radius.sin() {
                    continue;
                }
                let (turn, mut largest) = (turn_to(&centre), [[0.0_f32; 4]; 3]);
                for probe in &families[family] {
                    let is_near = half_sine <= (0.5 * probe.radius).sin();
                    let sums = lanes::sums(kernel, &turn, probe);
                    let errors = gauge.errors_of(&sums, probe, if is_near { peak } else { 0.0 });
                    for (largest, error) in largest.as_flattened_mut().iter_mut().zip(errors.as_flattened()) {
                        *largest = larger(*largest, *error);
                    }
                }
                // What one sample says exactly is not left out.
                if K::APART && largest[0][1] <= EXACT * largest[0][0] {
                    largest.iter_mut().for_each(|errors| errors[0] = f32::INFINITY);
                }
                // Never exactly none, as not every pixel was probed.
                *entry = largest.map(|errors| errors.map(|error| code(MARGIN * f64::from(error)).max(1)));
            }
        }
    }
}

/// A rotation, row by row, that takes +z to a direction.
fn turn_to(z: &Vector3<f64>) -> [[f32; 3]; 3] {
    let other = if z.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
    let x = z.cross(&other).normalize();
    let y = z.cross(&x);
    [0, 1, 2].map(|k| [x[k] as f32, y[k] as f32, z[k] as f32])
}

fn worse(a: Entry, b: Entry) -> Entry {
    std::array::from_fn(|k| std::array::from_fn(|i| a[k][i].max(b[k][i])))
}

/// Errors for other lobes, as frames look them up.
#[derive(Debug, Clone)]
pub(in crate::backend::block_product) struct WideBounds {
    grid: Grid,
    /// [cell of the viewer][family][row][column]
    entries: Vec<Codes>,
}

impl WideBounds {
    pub(in crate::backend::block_product) fn new(nodes: &WideNodes) -> Self {
        let grid = nodes.grid;
        let len = grid.families * grid.plane();
        let mut entries = Vec::with_capacity(grid.elevations * grid.azimuths * len);
        for cell in 0..grid.elevations * grid.azimuths {
            let corners = grid.corners(cell).map(|node| &nodes.entries[node * len..][..len]);
            let slice: Vec<Entry> = (0..len).map(|i| corners.iter().fold(NONE, |all, at| worse(all, at[i]))).collect();
            slice.chunks_exact(grid.plane()).for_each(|plane| increase(plane, grid.columns(), &mut entries));
        }
        Self { grid, entries }
    }

    /// A look-up for one viewer, in world coordinates; None if there is none for so low a viewer.
    pub(in crate::backend::block_product) fn seen_from(&self, axes: &Axes, wo: &Vector3<f64>) -> Option<WideView<'_>> {
        let (grid, local) = (&self.grid, axes.to_local(wo));
        if local.z < LEAST {
            return None;
        }
        // The viewer, turned or mirrored to where the table has him.
        let flat = local.x.hypot(local.y);
        let mut along = if flat > 0.0 { [local.x / flat, local.y / flat] } else { [1.0, 0.0] };
        let mut signs = [1.0; 2];
        let azimuth = match grid.symmetry {
            Symmetry::Turned => 0,
            Symmetry::Mirrored => {
                signs = along.map(|x| if x < 0.0 { -1.0 } else { 1.0 });
                along = along.map(f64::abs);
                cell_of(round_square(along) as f32, grid.azimuths)
            }
            Symmetry::None => cell_of((0.25 * round_square(along)) as f32, grid.azimuths),
        };
        let elevation = cell_of((1.0 - local.z).max(0.0).sqrt() as f32, grid.elevations);
        let len = grid.families * grid.plane();
        let viewer = Viewer { along, flat, z: local.z };
        let world = |d: Vector3<f64>| narrow(&axes.to_world(&Vector3::new(signs[0] * d.x, signs[1] * d.y, d.z)));
        Some(WideView {
            grid: *grid,
            entries: &self.entries[(elevation * grid.azimuths + azimuth) * len..][..len],
            axes: viewer.axes().map(world),
        })
    }
}

/// Appends a plane with each entry increased for what lies between it and its neighbours.
fn increase(plane: &[Entry], columns: usize, to: &mut Vec<Codes>) {
    let (rows, mut more) = (plane.len() / columns, plane.to_vec());
    for row in 0..rows - 1 {
        for column in 0..columns - 1 {
            let corners = [0, 1, columns, columns + 1].map(|next| row * columns + column + next);
            for k in 0..12 {
                let code = |at: usize| plane[at].as_flattened()[k];
                let (lowest, highest) =
                    corners.iter().fold((u16::MAX, 0), |(low, high), &at| (code(at).min(low), code(at).max(high)));
                let range = u32::from(highest - lowest);
                let margin = (range * range).div_ceil(CURVED);
                for at in corners {
                    let raised = (u32::from(code(at)) + margin).min(u32::from(highest)) as u16;
                    let entry = &mut more[at].as_flattened_mut()[k];
                    *entry = raised.max(*entry);
                }
            }
        }
    }
    to.extend(more.iter().map(Codes::of));
}

/// R²/8 octaves in codes: (range/STEPS)²/8 · STEPS.
const CURVED: u32 = 8 * STEPS as u32;

/// The errors of a lobe for one viewer.
#[derive(Debug, Clone, Copy)]
pub(in crate::backend::block_product) struct WideView<'a> {
    grid: Grid,
    /// [family][row][column]
    entries: &'a [Codes],
    /// x, y and mirror direction of the slice, in world coordinates.
    axes: [[f32; 3]; 3],
}

/// Where a block's errors are in a slice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(in crate::backend::block_product) struct Position(u32);

impl WideView<'_> {
    /// The places of blocks whose centres and families are given.
    #[inline(always)]
    pub(in crate::backend::block_product) fn find(
        &self,
        [x, y, z]: &[Vec<f32>; 3],
        families: &[u8],
        places: &mut [Position],
    ) {
        let Grid { symmetry, reach, .. } = self.grid;
        let (columns, plane) = (self.grid.columns() as u32, self.grid.plane() as u32);
        let is_half = symmetry == Symmetry::Turned;
        let (fine, last) = (FINE as f32 * reach as f32, (2 * reach as u32 * FINE - 1) as f32);
        let last_row = if is_half { fine - 1.0 } else { last };
        let whole = if self.grid.families > 1 { plane } else { 0 };
        let centres = x.iter().zip(y).zip(z).zip(families);
        for ((((&x, &y), &z), &family), place) in centres.zip(places) {
            let [a, b, c] = self.axes.map(|axis| axis[0] * x + axis[1] * y + axis[2] * z);
            // (a, b)/√(2(1 + c)) is sin(θ/2) times the direction; at θ = π any direction is as good.
            let opposite = 1.0 + c;
            let scale = fine / (2.0 * if opposite > 1e-6 { opposite } else { 1e-6 }).sqrt();
            let column = steps(a * scale + fine, last);
            let row = steps(if is_half { b.abs() * scale } else { b * scale + fine }, last_row);
            let at = u32::from(family) * whole + row / FINE * columns + column / FINE;
            *place = Position((at << 6) | ((row % FINE) << 3) | (column % FINE));
        }
    }

    /// The fewest samples of a block at a place: none, 1, 4, 16, pixels.
    #[inline(always)]
    pub(in crate::backend::block_product) fn class(
        &self,
        Position(place): Position,
        checks: &Checks,
        free: bool,
    ) -> SampleClass {
        let (corners, weights) = self.corners(place);
        Codes::class_between(corners, weights, checks, free)
    }

    /// The nodes about a place, and their weights.
    #[inline(always)]
    fn corners(&self, place: u32) -> ([&Codes; 4], [u64; 4]) {
        let (at, row, column) = ((place >> 6) as usize, u64::from((place >> 3) & 7), u64::from(place & 7));
        let (columns, fine) = (self.grid.columns(), u64::from(FINE));
        let near = &self.entries[at..][..columns + 2];
        let weights = [(fine - row) * (fine - column), (fine - row) * column, row * (fine - column), row * column];
        ([&near[0], &near[1], &near[columns], &near[columns + 1]], weights)
    }
}

/// The nearest whole number, from 0 to `last`.
#[inline(always)]
fn steps(x: f32, last: f32) -> u32 {
    // 2²³ leaves the whole number in the low bits.
    const ROUND: f32 = 8_388_608.0;
    let x = if x > 0.0 { x } else { 0.0 };
    let x = if x < last { x } else { last };
    (x + ROUND).to_bits() - ROUND.to_bits()
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Unit};

    use super::super::errors::Errors;
    use super::super::gauge::LEFT_OUT;
    use super::*;
    use crate::backend::block_product::interpolation::{Interpolation, SampleBasis};
    use crate::backend::block_product::layout::BlockLayout;
    use crate::compress::ScanOrder;
    use crate::scene::{Brdf, CookTorrance, Lobe, Ward};
    use crate::sphere::CubeGrid;

    /// Numbers in [0, 1).
    fn random(i: usize) -> f64 {
        ((i as f64 + 0.5) * 0.618_033_988_749_894_9).fract()
    }

    /// How many octaves a table has more than the errors of a whole block, at viewers, places and turns of all kinds:
    /// the least and the mean.
    fn surplus(
        bounds: &WideBounds,
        gauge: &Gauge,
        lobe: impl Fn(&Vector3<f64>, &Vector3<f64>) -> f64,
    ) -> ([f64; 12], f64) {
        let (mut least, mut sum, mut count) = ([f64::INFINITY; 12], 0.0, 0.0);
        let axes = local_axes();
        for i in 0..4000 {
            let turn = |k: usize| std::f64::consts::TAU * random(5 * i + k * 7919);
            let z = 0.03 + 0.97 * random(3 * i + 1);
            let wo = Vector3::new(turn(1).cos() * (1.0 - z * z).sqrt(), turn(1).sin() * (1.0 - z * z).sqrt(), z);
            let shape = i % gauge.shapes.len();
            // Above the horizon as a whole: what lies below is for the tests of whole frames.
            let lowest = gauge.radius.sin() + 0.01;
            let height = lowest + (1.0 - lowest) * random(11 * i + 5);
            let flat = (1.0 - height * height).sqrt();
            let centre = Vector3::new(flat * turn(2).cos(), flat * turn(2).sin(), height);
            let to =
                Rotation3::rotation_between(&Vector3::z_axis(), &Unit::new_normalize(centre)).expect("not opposite");
            let to = to * Rotation3::from_axis_angle(&Vector3::z_axis(), turn(3));
            let exact: Errors = gauge.errors(&gauge.shapes[shape], |d| {
                let wi = to * d;
                Vector3::new(lobe(&wi, &wo) * wi.z, 0.0, 0.0)
            });
            let view = bounds.seen_from(&axes, &wo).expect("high enough");
            let family = gauge.families.len() - 1;
            let family =
                (0..=family).find(|&g| gauge.family_of_shape(shape) == g as u8).expect("every shape has a family");
            let mut place = [Position::default()];
            let centre = [centre.x, centre.y, centre.z].map(|x| vec![x as f32]);
            view.find(&centre, &[family as u8], &mut place);
            let (corners, weights) = view.corners(place[0].0);
            let got = Codes::between(corners, weights).all();
            for (k, want) in Codes::exactly(exact).all().into_iter().enumerate() {
                // What is smaller than anything that is ever allowed says nothing.
                if want > 400 {
                    let less = if k % 4 == 0 { f64::from(LEFT_OUT).log2() } else { 0.0 };
                    let octaves = (f64::from(got[k]) - f64::from(want)) / STEPS - less;
                    least[k] = octaves.min(least[k]);
                    (sum, count) = (sum + octaves, count + 1.0);
                }
            }
        }
        assert!(count > 1000.0);
        (least, sum / count)
    }

    #[test]
    fn a_table_is_above_what_blocks_make_and_not_far() {
        let layout = BlockLayout::new(CubeGrid::new(64).unwrap(), 16, ScanOrder::RowMajor).unwrap();
        let gauge = Gauge::new(&layout, &Interpolation::new(16, SampleBasis::Polynomial).unwrap());
        let mut all = Vec::new();
        for alpha in [[0.1; 2], [0.2; 2], [0.5; 2], [0.15, 0.4]] {
            let symmetry = if alpha[0] == alpha[1] { Symmetry::Turned } else { Symmetry::Mirrored };
            let ggx = CookTorrance::new([1.0; 3], alpha[0], alpha[1]).unwrap();
            let ward = Ward::new([1.0; 3], alpha[0], alpha[1]).unwrap();
            let both: [(&dyn Brdf, Lobe); 2] = [(&ggx, Lobe::CookTorrance(ggx)), (&ward, Lobe::Ward(ward))];
            all.extend(both.map(|(brdf, lobe)| {
                let nodes = WideNodes::measure(&gauge, symmetry, &LobeSource::Known(lobe));
                let factor = lobe.factor().x;
                surplus(&WideBounds::new(&nodes), &gauge, |wi, wo| brdf.eval(wi, wo).x / factor)
            }));
        }
        for (least, mean) in all {
            assert!(least.iter().all(|&least| least >= 0.0), "a table is too low by {least:?} octaves");
            assert!(mean <= 3.0, "a table is too high by {mean} octaves");
        }
    }
}
