//! Frames: lights carried to every vertex and met there by its transport.

use nalgebra::Vector3;

use super::incident::{IncidentLight, clamp};
use super::light::PlanarLight;
use super::pixels::PixelRows;
use super::rows::Rows;
use super::settings::{Route, Settings, TargetSelection};
use super::tables::{Couplings, TableScratch};
use super::transport::Transport;
use crate::affine::{AffineMap, MapGrid, PixelOperator, Prediction, PropagationRoute, PropagationScratch, Targets};
use crate::error::check_length;
use crate::haar::{Decomposition, Transform2d};
use crate::scene::View;
use crate::{Error, Result, parallel};

/// Relights a scene from its [`Transport`] under planar lights that move, grow, turn and are painted.
///
/// ```math
/// B(v) = Σ_lights Σ_i Σ_k F_i T_k(v) D_ik(z, x)                                         [Sun 2008, eq. 4.36]
/// ```
///
/// A vertex in the plane of a light or behind it gets nothing of it. Lights shine against the normal of the
/// transport's frame; several are added up. Each has a height of its own.
///
/// The results are the same bits for any number of threads. After the first frame nothing is allocated, neither by
/// [`relight`](Self::relight) nor by [`set_light`](Self::set_light), but for targets that are
/// [predicted](TargetSelection::Predicted) for a place for the first time.
#[derive(Debug)]
pub struct Relighter<'a> {
    pub(super) transport: &'a Transport,
    pub(super) settings: Settings<'a>,
    pub(super) lights: Vec<IncidentLight>,
    routes: Vec<Route>,
    /// Of each row: the factor of the view; empty if the view is not free.
    pub(super) view: Vec<f32>,
    pub(super) pixels: Option<PixelRows>,
    couplings: Option<Couplings>,
    prediction: Option<Prediction<2>>,
    memory: Vec<Memory>,
}

/// What a piece of the vertices has for itself.
#[derive(Debug)]
struct Memory {
    targets: Targets,
    chosen: Vec<u32>,
    planes: Vec<f32>,
    /// L of all wavelets, R, G, B and nothing; 0 between vertices.
    dense: Vec<[f32; 4]>,
    scratch: PropagationScratch<f32>,
    table: TableScratch,
    operator: PixelOperator<f32>,
    image: Vec<f32>,
    shaped: Vec<f32>,
}

/// Scales and offsets of places whose targets are predicted together.
const PREDICTED_SCALES: [f64; 2] = [1.0 / 16.0, 16.0];
const PREDICTED_CELLS: [usize; 2] = [16, 24];

/// With more rows than this a vertex wants all wavelets: its own are most of them.
const FEW_ROWS: usize = 3;

/// Couplings are cheaper than pixels for lights of so few wavelets (see `docs/near_field.md`).
const FEW_TERMS: usize = 2;

impl<'a> Relighter<'a> {
    /// A relighter without light. A transport whose view is free is seen from above, along the normal of each vertex,
    /// until [`set_view`](Self::set_view).
    ///
    /// Cost: for the routes through pixels, cells² numbers for each row of the transport, of as many bits as its own.
    ///
    /// # Errors
    /// [`Error::NotPowerOfTwo`] unless the side of the sources is one; [`Error::OutOfRange`] above 256, and for
    /// fractions of terms outside [0, 1]; [`Error::Length`] for a route by tables with sources of another side than the
    /// face; what [`Prediction::new`] refuses.
    pub fn new(transport: &'a Transport, settings: Settings<'a>) -> Result<Self> {
        let (cells, side) = (transport.face.cells(), settings.source_side);
        // What is wrong with the settings shows with the first light, and so here.
        IncidentLight::new(transport.face, transport.frame, settings)?;
        let sides = [side, cells];
        let couplings = match settings.route {
            Route::StoredCouplings => Some(Couplings::stored(sides)?),
            Route::CanonicalTable => Some(Couplings::canonical(sides)?),
            _ => None,
        };
        let prediction = match settings.targets {
            TargetSelection::Predicted { heuristic, keep, union, samples } => {
                let grid = MapGrid::new(PREDICTED_SCALES, PREDICTED_CELLS)?;
                let plan = Prediction::<2>::new(cells, Decomposition::Standard, heuristic, grid, keep)?;
                Some(plan.with_samples(samples).with_union(union))
            }
            _ => None,
        };
        let memory = || -> Result<Memory> {
            Ok(Memory {
                targets: Targets::all(cells, Decomposition::Standard)?,
                chosen: Vec::with_capacity(cells * cells),
                planes: vec![0.0; 3 * cells * cells],
                dense: vec![[0.0; 4]; cells * cells],
                scratch: PropagationScratch::new(),
                table: TableScratch::default(),
                operator: PixelOperator::new(side, cells)?,
                image: vec![0.0; cells * cells],
                shaped: vec![0.0; cells * cells],
            })
        };
        let memory = (0..parallel::pieces()).map(|_| memory()).collect::<Result<_>>()?;
        let (lights, routes, view) = (Vec::new(), Vec::new(), Vec::new());
        let mut relighter =
            Self { transport, settings, lights, routes, view, pixels: None, couplings, prediction, memory };
        if matches!(settings.route, Route::Automatic | Route::Pixels) {
            relighter.decode()?;
        }
        relighter.weigh(None);
        Ok(relighter)
    }

    /// Images of all rows, if there are none yet.
    pub(super) fn decode(&mut self) -> Result<()> {
        if self.pixels.is_none() {
            self.pixels = Some(PixelRows::new(&self.transport.rows, self.transport.face.cells())?);
        }
        Ok(())
    }

    /// Sets all lights.
    ///
    /// # Errors
    /// None that a [`PlanarLight`] can be the reason of.
    pub fn set_lights(&mut self, lights: &[PlanarLight]) -> Result<()> {
        self.lights.truncate(lights.len());
        self.routes.truncate(lights.len());
        while self.lights.len() < lights.len() {
            self.lights.push(IncidentLight::new(self.transport.face, self.transport.frame, self.settings)?);
            self.routes.push(self.settings.route);
        }
        (0..lights.len()).try_for_each(|k| self.set_light(k, &lights[k]))
    }

    /// Sets one of the lights, after it has moved or been painted.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if there is no such light.
    pub fn set_light(&mut self, index: usize, light: &PlanarLight) -> Result<()> {
        let Some(incident) = self.lights.get_mut(index) else {
            let allowed = "below the number of lights that were set";
            return Err(Error::OutOfRange { what: "number of a light", got: index as f64, allowed });
        };
        incident.set(light)?;
        let route = match self.settings.route {
            // A profile multiplies cell by cell.
            _ if !incident.profile().is_empty() => Route::Pixels,
            Route::Automatic if incident.terms() <= FEW_TERMS => Route::Couplings,
            Route::Automatic => Route::Pixels,
            route => route,
        };
        self.routes[index] = route;
        if route == Route::Pixels {
            self.decode()?;
        }
        Ok(())
    }

    /// The lights as every vertex sees them.
    pub fn lights(&self) -> &[IncidentLight] {
        &self.lights
    }

    /// The route that each light takes.
    pub fn routes(&self) -> &[Route] {
        &self.routes
    }

    /// Looks at the scene from another view.
    ///
    /// Cost: a look-up a row, in parallel.
    ///
    /// # Errors
    /// [`Error::Baked`] for a view other than that of a transport that was baked for one.
    pub fn set_view(&mut self, view: &View) -> Result<()> {
        if self.transport.view.as_ref().is_some_and(|baked| baked != view) {
            return Err(Error::Baked { what: "view" });
        }
        self.weigh(Some(view));
        Ok(())
    }

    /// The factors of the view of all rows.
    fn weigh(&mut self, view: Option<&View>) {
        let Some(free) = &self.transport.free else { return };
        let (rows, positions) = (&self.transport.rows, &self.transport.positions);
        self.view.resize(rows.len(), 1.0);
        let end = |vertex: usize| if vertex == 0 { 0 } else { rows.of(vertex - 1).end };
        parallel::ragged(
            &mut self.view,
            rows.vertices(),
            end,
            || vec![0.0; free.terms()],
            |vertex, out, outgoing| {
                let Some(factored) = &free.factors[free.parts[vertex] as usize] else { return out.fill(1.0) };
                let wo = view.map_or(Vector3::z(), |view| free.frame(vertex).to_local(&view.wo(&positions[vertex])));
                factored.outgoing_terms(&wo, &mut outgoing[..factored.terms()]);
                let terms = &rows.term[rows.of(vertex)];
                out.iter_mut().zip(terms).for_each(|(out, &term)| *out = clamp(outgoing[usize::from(term)]));
            },
        );
    }

    /// The radiance of every vertex, in parallel; finite (at most [`f32::MAX`]).
    ///
    /// # Panics
    /// Unless `out` has one value a vertex.
    #[track_caller]
    pub fn relight(&mut self, out: &mut [Vector3<f32>]) {
        check_length("radiance of the vertices", self.transport.vertices(), out.len());
        let mut memory = std::mem::take(&mut self.memory);
        let this = &*self;
        let done = parallel::with_scratch(out, 1, &mut memory, |first, out, memory| {
            out.iter_mut().enumerate().for_each(|(i, out)| *out = this.vertex(first + i, memory));
            Ok(())
        });
        self.memory = memory;
        done.expect("nothing here fails");
    }

    fn vertex(&self, vertex: usize, memory: &mut Memory) -> Vector3<f32> {
        let (rows, mut sum) = (self.transport.rows.of(vertex), [0.0_f64; 3]);
        if rows.is_empty() {
            return Vector3::zeros();
        }
        let position = self.transport.positions[vertex].cast();
        for (light, &route) in self.lights.iter().zip(&self.routes) {
            let Some(maps) = light.maps(&position) else { continue };
            let factor = light.factor();
            let mut add = |row: usize, integral: [f32; 3]| {
                let view = self.view.get(row).copied().unwrap_or(1.0);
                let weight = self.transport.rows.weight[row];
                let view = f64::from(view) * factor;
                (0..3).for_each(|c| sum[c] += f64::from(weight[c]) * f64::from(integral[c]) * view);
            };
            match (route, &self.pixels) {
                (Route::Pixels, Some(pixels)) => {
                    let pixels = (pixels, &self.transport.rows.weight[..]);
                    meet_in_pixels(light, maps, rows.clone(), pixels, memory, &mut add);
                }
                _ => {
                    self.carry(light, route, vertex, maps, memory);
                    for row in rows.clone() {
                        let [r, g, b, _] = self.transport.rows.dot(row, &memory.dense);
                        add(row, [r, g, b]);
                    }
                    // Chosen targets are zeroed one by one: there are fewer.
                    if memory.chosen.is_empty() {
                        continue;
                    }
                    memory.chosen.iter().for_each(|&k| memory.dense[k as usize] = [0.0; 4]);
                }
            }
        }
        if !sum.iter().all(|x| x.is_finite()) {
            return self.wide_vertex(vertex);
        }
        sum.map(clamp).into()
    }

    /// As [`vertex`](Self::vertex), in `f64` and with all targets, where sums leave the range of `f32` on the way: by
    /// numbers that no measured reflectance has.
    #[cold]
    fn wide_vertex(&self, vertex: usize) -> Vector3<f32> {
        let (side, cells) = (self.settings.source_side, self.transport.face.cells());
        let sizes = "the relighter has checked the sides";
        let mut operator = PixelOperator::<f64>::new(side, cells).expect(sizes);
        let transform = Transform2d::<f64>::new(cells, cells, Decomposition::Standard).expect(sizes);
        let (rows, position) = (&self.transport.rows, self.transport.positions[vertex].cast());
        let mut work = vec![0.0; transform.scratch_len()];
        let (mut image, mut columns) = (vec![0.0; cells * cells], vec![0.0; cells * cells]);
        let mut sum = [0.0; 3];
        for light in &self.lights {
            let Some(maps) = light.maps(&position) else { continue };
            operator.set(maps);
            let source = light.pixels().map(|plane| plane.iter().map(|&x| f64::from(x)).collect::<Vec<_>>());
            for row in rows.of(vertex) {
                image.fill(0.0);
                rows.for_each(row, |i, value| image[i] = f64::from(value));
                transform.inverse_in_place(&mut image, &mut work);
                for (i, out) in columns.iter_mut().enumerate() {
                    let share = light.profile().get(i).copied().map_or(1.0, f64::from);
                    *out = image[i % cells * cells + i / cells] * share / (cells * cells) as f64;
                }
                let integral = operator.inner_products(source.each_ref().map(Vec::as_slice), &columns);
                let view = f64::from(self.view.get(row).copied().unwrap_or(1.0)) * light.factor();
                (0..3).for_each(|c| sum[c] += f64::from(rows.weight[row][c]) * integral[c] * view);
            }
        }
        sum.map(clamp).into()
    }

    /// Writes the wavelets of a light at a vertex to `dense`; `chosen` are those that were, or none if all.
    fn carry(&self, light: &IncidentLight, route: Route, vertex: usize, maps: [AffineMap; 2], memory: &mut Memory) {
        let cells = self.transport.face.cells();
        if let Some(couplings) = &self.couplings {
            memory.chosen.clear();
            couplings.propagate(light.source(), maps, cells, &mut memory.dense, &mut memory.table);
            return;
        }
        let Memory { targets, chosen, planes, dense, scratch, .. } = memory;
        let all = choose(self.settings.targets, &self.transport.rows, self.prediction.as_ref(), vertex, maps, chosen);
        let len = if all { cells * cells } else { chosen.len() };
        if !all {
            targets.set(chosen).expect("wavelets of the face, ascending");
        } else if targets.len() != len {
            *targets = Targets::all(cells, Decomposition::Standard).expect("the transport has checked the side");
        }
        let [r, rest] = split(&mut planes[..3 * len], len);
        let [g, b] = split(rest, len);
        let (plan, source) = (light.plan(), light.source());
        match route {
            Route::SummedArea => {
                plan.apply_by(PropagationRoute::Lookups, source, maps, targets, [&mut *r, &mut *g, &mut *b], scratch);
            }
            _ => plan.apply_by(PropagationRoute::Wavelets, source, maps, targets, [&mut *r, &mut *g, &mut *b], scratch),
        }
        let values = r.iter().zip(&*g).zip(&*b).map(|((&r, &g), &b)| [r, g, b, 0.0]);
        if all {
            dense.iter_mut().zip(values).for_each(|(dense, value)| *dense = value);
        } else {
            chosen.iter().zip(values).for_each(|(&k, value)| dense[k as usize] = value);
        }
    }

    /// Bytes in memory that grow with the number of vertices, beside the transport's.
    pub fn bytes(&self) -> usize {
        self.pixels.as_ref().map_or(0, PixelRows::bytes) + size_of_val(self.view.as_slice())
    }

    /// Bytes of tables of couplings.
    pub fn table_bytes(&self) -> usize {
        self.couplings.as_ref().map_or(0, Couplings::bytes)
    }
}

fn split<T>(all: &mut [T], len: usize) -> [&mut [T]; 2] {
    let (a, b) = all.split_at_mut(len);
    [a, b]
}

/// Fills in the targets of a vertex; `true` if these are all, and the list is empty then.
fn choose(
    selection: TargetSelection<'_>,
    rows: &Rows,
    prediction: Option<&Prediction<2>>,
    vertex: usize,
    maps: [AffineMap; 2],
    chosen: &mut Vec<u32>,
) -> bool {
    chosen.clear();
    match (selection, prediction) {
        (TargetSelection::Predicted { .. }, Some(prediction)) => {
            chosen.extend_from_slice(prediction.targets(maps));
            false
        }
        (TargetSelection::Transport, _) if rows.of(vertex).len() <= FEW_ROWS => {
            let of = rows.of(vertex);
            for row in of.clone() {
                chosen.extend(rows.index[rows.entries_of(row)].iter().map(|&i| u32::from(i)));
            }
            if of.len() > 1 {
                chosen.sort_unstable();
                chosen.dedup();
            }
            false
        }
        _ => true,
    }
}

/// Σ over the cells of radiance × transport, for each row.
fn meet_in_pixels(
    light: &IncidentLight,
    maps: [AffineMap; 2],
    rows: std::ops::Range<usize>,
    (pixels, weights): (&PixelRows, &[[f32; 3]]),
    memory: &mut Memory,
    add: &mut impl FnMut(usize, [f32; 3]),
) {
    let Memory { operator, image, shaped, planes, .. } = memory;
    operator.set(maps);
    let (source, profile) = (light.pixels(), light.profile());
    if rows.len() <= FEW_ROWS {
        // One image a row to the light, rather than three to the vertex.
        for row in rows {
            let (mut transport, factor) = pixels.of(row, image);
            if !profile.is_empty() {
                shaped.iter_mut().zip(transport).zip(profile).for_each(|((out, t), p)| *out = t * p);
                transport = shaped;
            }
            let integral = match only_channel(weights[row]) {
                Some(c) => {
                    let [integral] = operator.inner_products([source[c]], transport);
                    std::array::from_fn(|k| if k == c { integral } else { 0.0 })
                }
                None => operator.inner_products(source, transport),
            };
            add(row, integral.map(|x| x * factor));
        }
        return;
    }
    let area = image.len();
    for (source, plane) in source.into_iter().zip(planes.chunks_exact_mut(area)) {
        operator.apply(source, plane);
        if !profile.is_empty() {
            plane.iter_mut().zip(profile).for_each(|(l, p)| *l *= p);
        }
    }
    for row in rows {
        let (transport, factor) = pixels.of(row, image);
        add(row, [0, 1, 2].map(|c| factor * dot(transport, &planes[c * area..][..area])));
    }
}

/// The only channel that a row adds to.
fn only_channel(weight: [f32; 3]) -> Option<usize> {
    match weight.map(|w| w != 0.0) {
        [true, false, false] => Some(0),
        [false, true, false] => Some(1),
        [false, false, true] => Some(2),
        _ => None,
    }
}

/// In sixteen sums, so that lanes work side by side.
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0_f32; 16];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<16>(), b.as_chunks::<16>());
    for (a, b) in a.iter().zip(b) {
        for k in 0..16 {
            sums[k] += a[k] * b[k];
        }
    }
    sums.iter().sum::<f32>() + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f32>()
}
