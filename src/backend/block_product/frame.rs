//! One frame: what every vertex sends to the viewer.

use nalgebra::Vector3;

use super::bounds::{Checks, Position, WideView};
use super::cases::Cases;
use super::layout::BlockLayout;
use super::light::LightForms;
use super::live::{Live, LiveBlocks};
use super::lobes::{Plan, PlannedLobe, Planner, Sampling};
use super::products::{Cut, LobeSum, Moments};
use super::rule::{BlockAngle, Rule, SampleClass, fixed};
use super::samples::Samples;
use super::schedule::{GROUP, Group, Schedule};
use super::settings::Settings;
use super::stats::FrameStats;
use super::suffix::MomentSums;
use super::tables::Directions;
use super::tiles::TILE;
use super::visible::{Room, Visible};
use crate::compress::MapState;
use crate::parallel;
use crate::scene::{Axes, Kernel, KernelVisitor, Materials, Mesh, View, narrow};

/// Work space of a piece of the vertices.
#[derive(Debug, Clone)]
pub(super) struct Scratch {
    /// [vertex of a group]
    seen: Vec<Option<Seen>>,
    wanted: Box<[bool; GROUP]>,
    moments: Box<[MomentSums; GROUP]>,
    samples: Samples,
    live: Vec<Live>,
    cases: Cases,
    /// [block]: where it is in a table.
    positions: Vec<Position>,
    /// A bit a block: those that may need samples.
    near: Vec<u64>,
    room: Room,
}

impl Scratch {
    pub(super) fn new(layout: &BlockLayout) -> Self {
        let blocks = layout.blocks();
        Self {
            seen: Vec::with_capacity(GROUP),
            wanted: Box::new([false; GROUP]),
            moments: Box::new([MomentSums::default(); GROUP]),
            samples: Samples::new(),
            live: Vec::with_capacity(blocks),
            cases: Cases::new(blocks),
            positions: vec![Position::default(); blocks],
            near: vec![!0; blocks.div_ceil(64)],
            room: Room::new(layout.block_len()),
        }
    }
}

/// What frames read and do not change.
#[derive(Debug, Clone)]
pub(super) struct Inputs<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) settings: Settings,
    pub(super) light: LightForms,
    pub(super) directions: Directions,
    /// Knows the materials.
    pub(super) planner: Planner,
    /// [vertex]: whether its radiance is asked for; empty if all are.
    pub(super) needed: Vec<bool>,
    pub(super) live: LiveBlocks,
    pub(super) arch: pulp::Arch,
}

/// One frame.
#[derive(Clone, Copy)]
pub(super) struct Frame<'f, 'a> {
    pub(super) inputs: &'f Inputs<'a>,
    pub(super) view: &'f View,
    pub(super) materials: &'f Materials,
}

/// A vertex and its viewer.
#[derive(Debug, Clone, Copy)]
struct Seen {
    normal: Vector3<f64>,
    wo: Vector3<f64>,
}

/// The same as lobes see it.
struct Facing {
    axes: Axes,
    wo: Vector3<f64>,
    normal: [f32; 3],
    /// The direction to the viewer, mirrored.
    mirror: [f32; 3],
}

impl Frame<'_, '_> {
    pub(super) fn run<V: Visible>(
        self,
        (maps, schedule): (&V, &Schedule<V::Change>),
        scratch: &mut [Scratch],
        out: &mut [Vector3<f32>],
    ) {
        let done = parallel::with_scratch(out, GROUP, scratch, |first, out, scratch| {
            for (k, out) in out.chunks_mut(GROUP).enumerate() {
                let first = first + k * GROUP;
                self.group(maps, schedule.group(first / GROUP), first, scratch, out);
            }
            Ok(())
        });
        done.expect("no piece fails");
    }

    fn is_needed(self, vertex: usize) -> bool {
        self.inputs.needed.get(vertex).copied().unwrap_or(true)
    }

    fn plan(&self, vertex: usize) -> &Plan {
        &self.inputs.planner.plans()[self.materials.part(vertex)]
    }

    /// The radiance of a group of vertices.
    fn group<V: Visible>(
        self,
        maps: &V,
        group: Group<'_, V::Change>,
        first: usize,
        scratch: &mut Scratch,
        out: &mut [Vector3<f32>],
    ) {
        let Scratch { seen, wanted, moments, .. } = scratch;
        seen.clear();
        seen.extend((first..first + out.len()).map(|vertex| self.seen(vertex)));
        for (i, (wanted, seen)) in wanted.iter_mut().zip(seen.iter()).enumerate() {
            *wanted = seen.is_some() && self.plan(first + i).diffuse != Vector3::zeros();
        }
        if wanted[..out.len()].contains(&true) {
            moments.fill(MomentSums::default());
            let Inputs { light, arch, .. } = self.inputs;
            arch.dispatch(Moments { maps, light, group, wanted, sums: moments });
        }
        for (i, radiance) in out.iter_mut().enumerate() {
            *radiance = match scratch.seen[i] {
                Some(seen) => {
                    let sum = self.vertex(maps, first + i, &seen, i, scratch) * self.inputs.light.scale;
                    // NaN stays.
                    sum.map(|x| x.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32)
                }
                None => Vector3::zeros(),
            };
        }
    }

    /// None for a vertex that is not needed or whose viewer is below the horizon.
    fn seen(self, vertex: usize) -> Option<Seen> {
        if !self.is_needed(vertex) {
            return None;
        }
        let (mesh, frame) = (self.inputs.mesh, self.inputs.mesh.local_frame(vertex));
        let normal = Axes::upright(&frame);
        let wo = self.view.outgoing(self.materials.brdf(vertex), &mesh.positions()[vertex], &frame);
        (normal.dot(&wo) > 0.0).then_some(Seen { normal, wo })
    }

    fn facing(self, vertex: usize, seen: &Seen) -> Facing {
        let axes = Axes::new(&self.inputs.mesh.local_frame(vertex));
        let local = axes.to_local(&seen.wo);
        let mirror = narrow(&axes.to_world(&Vector3::new(-local.x, -local.y, local.z)));
        Facing { axes, wo: seen.wo, normal: narrow(&seen.normal), mirror }
    }

    /// The radiance of number `i` of a group.
    fn vertex<V: Visible>(self, maps: &V, vertex: usize, seen: &Seen, i: usize, scratch: &mut Scratch) -> Vector3<f64> {
        let plan = self.plan(vertex);
        let mut sum = Vector3::zeros();
        if scratch.wanted[i] {
            sum = Vector3::from(scratch.moments[i].along(seen.normal.into())).component_mul(&plan.diffuse);
        }
        if plan.lobes.is_empty() {
            return sum;
        }
        let facing = self.facing(vertex, seen);
        for lobe in &plan.lobes {
            self.classify(vertex, lobe, &facing, scratch);
            sum += self.lobe(maps, vertex, lobe, &facing, scratch).component_mul(&lobe.factor);
        }
        sum
    }

    /// The case of each live block.
    fn classify(self, vertex: usize, lobe: &PlannedLobe, seen: &Facing, scratch: &mut Scratch) {
        let Inputs { directions, arch, .. } = self.inputs;
        let Scratch { live, cases, near, positions, .. } = scratch;
        match &lobe.sampling {
            Sampling::Mirror { .. } => {
                arch.dispatch(Near { mirror: seen.mirror, centres: &directions.centres, reach: &lobe.reach, near })
            }
            _ => near.fill(!0),
        }
        self.inputs.live.list(vertex, near, live);
        match &lobe.sampling {
            Sampling::Pixels => cases.set(live, |_| SampleClass::PIXELS),
            Sampling::Fixed(exponent) => {
                let fixed = fixed(*exponent);
                let nearest = matches!(self.inputs.settings.rule, Rule::Fixed { angle: BlockAngle::Nearest });
                let limits = &directions.limits[usize::from(nearest)];
                cases.set(live, |live| {
                    let block = live.block as usize;
                    let (cosine, [near, middle]) = (dot(seen.mirror, at(&directions.centres, block)), limits[block]);
                    fixed[if cosine > near { 0 } else { 1 + usize::from(cosine <= middle) }]
                });
            }
            Sampling::Mirror { bounds, .. } => {
                cases.set(live, |live| {
                    let block = live.block as usize;
                    let codes = bounds.codes(dot(seen.mirror, at(&directions.centres, block)));
                    codes.class(&lobe.checks[block], live.free)
                });
            }
            Sampling::Wide { bounds, .. } => {
                let (checks, families) = (&lobe.checks[..], self.inputs.planner.families());
                match bounds.seen_from(&seen.axes, &seen.wo) {
                    Some(view) => {
                        let centres = &directions.centres;
                        arch.dispatch(Classes { view, centres, families, positions, live, checks, cases });
                    }
                    None => cases.set(live, |_| SampleClass::PIXELS),
                }
            }
        }
    }

    fn lobe<V: Visible>(
        self,
        maps: &V,
        vertex: usize,
        lobe: &PlannedLobe,
        seen: &Facing,
        scratch: &mut Scratch,
    ) -> Vector3<f64> {
        let (axes, wo) = (&seen.axes, &seen.wo);
        let is_cut = matches!(lobe.sampling, Sampling::Mirror { .. });
        let cut = is_cut.then(|| Cut { mirror: seen.mirror, least: &lobe.least });
        let run = LobeRun { frame: self, vertex, seen, cut };
        let sum = lobe.source.visit(axes, wo, Integral { run, maps, scratch });
        Vector3::from(sum.unwrap_or_default())
    }

    pub(super) fn count<V: Visible>(self, maps: &V, scratch: &mut Scratch) -> FrameStats {
        let mut stats = FrameStats::default();
        let blocks = self.inputs.light.layout().blocks();
        let mut most = vec![SampleClass::NONE; blocks];
        for vertex in 0..self.inputs.mesh.positions().len() {
            let Some(seen) = self.seen(vertex) else { continue };
            let (plan, seen) = (self.plan(vertex), self.facing(vertex, &seen));
            let is_diffuse = plan.diffuse != Vector3::zeros();
            most.fill(if is_diffuse { SampleClass::ONE } else { SampleClass::NONE });
            for lobe in &plan.lobes {
                self.classify(vertex, lobe, &seen, scratch);
                for (course, class) in scratch.cases.classes() {
                    let most = &mut most[course % blocks];
                    *most = class.max(*most);
                }
            }
            let states = (0..blocks).map(|block| maps.state(vertex * blocks + block));
            stats = states.zip(&most).fold(stats, |stats, (state, &class)| stats.add(one_block(state, class)));
            stats.vertices += 1;
        }
        stats
    }
}

/// One lobe at one vertex.
struct LobeRun<'r, 'f, 'a> {
    frame: Frame<'f, 'a>,
    vertex: usize,
    seen: &'r Facing,
    cut: Option<Cut<'r>>,
}

/// Its integral, by whichever kernel.
struct Integral<'r, 'f, 'a, 's, V> {
    run: LobeRun<'r, 'f, 'a>,
    maps: &'r V,
    scratch: &'s mut Scratch,
}

impl<V: Visible> KernelVisitor for Integral<'_, '_, '_, '_, V> {
    type Output = [f64; 3];

    fn visit<const N: usize, K: Kernel<N>>(self, kernel: K) -> [f64; 3] {
        let Self { run: LobeRun { frame, vertex, seen, cut }, maps, scratch } = self;
        let Scratch { samples, cases, room, .. } = scratch;
        let Inputs { light, directions, arch, .. } = frame.inputs;
        let (first, normal) = (vertex * light.layout().blocks(), seen.normal);
        let goes_on = matches!(frame.inputs.settings.rule, Rule::Bounded { .. });
        arch.dispatch(LobeSum { kernel, normal, maps, first, cases, light, directions, samples, room, cut, goes_on })
    }
}

/// The counts of one block.
fn one_block(state: MapState, class: SampleClass) -> FrameStats {
    let mut stats = FrameStats::default();
    if state == MapState::AllZero || class == SampleClass::NONE {
        stats.zero = 1;
        return stats;
    }
    stats.samples[class.index() - 1] = 1;
    match (state, class) {
        (_, SampleClass::PIXELS) => stats.pixels = 1,
        (MapState::AllOne, _) => stats.coefficients = 1,
        (_, SampleClass::ONE | SampleClass::FOUR) => stats.sums = 1,
        _ => unreachable!("16 samples behind a partly hidden block are all pixels"),
    }
    stats
}

/// The blocks whose centres are near enough to the mirror direction, a bit each.
struct Near<'a> {
    mirror: [f32; 3],
    centres: &'a [Vec<f32>; 3],
    /// [block]: the least cosine.
    reach: &'a [f32],
    near: &'a mut [u64],
}

impl pulp::WithSimd for Near<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        self.near.fill(0);
        let [x, y, z] = self.centres.each_ref().map(|plane| plane.as_chunks::<TILE>());
        let (reach, rest) = self.reach.as_chunks::<TILE>();
        for (k, (((x, y), z), reach)) in x.0.iter().zip(y.0).zip(z.0).zip(reach).enumerate() {
            let mut bits = [0_u32; TILE];
            for lane in 0..TILE {
                let cosine = dot(self.mirror, [x[lane], y[lane], z[lane]]);
                bits[lane] = u32::from(cosine >= reach[lane]) << lane;
            }
            let byte = bits.iter().fold(0, |byte, bit| byte | bit);
            self.near[k / 8] |= u64::from(byte) << (k % 8 * 8);
        }
        let first = self.reach.len() - rest.len();
        for (lane, &reach) in rest.iter().enumerate() {
            let cosine = dot(self.mirror, [x.1[lane], y.1[lane], z.1[lane]]);
            self.near[first / 64] |= u64::from(cosine >= reach) << ((first + lane) % 64);
        }
    }
}

/// The cases of blocks by a table of a lobe about the half vector.
struct Classes<'a> {
    view: WideView<'a>,
    centres: &'a [Vec<f32>; 3],
    families: &'a [u8],
    positions: &'a mut [Position],
    live: &'a [Live],
    checks: &'a [Checks],
    cases: &'a mut Cases,
}

impl pulp::WithSimd for Classes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        self.view.find(self.centres, self.families, self.positions);
        self.cases.set(self.live, |live| {
            let block = live.block as usize;
            self.view.class(self.positions[block], &self.checks[block], live.free)
        });
    }
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn at(planes: &[Vec<f32>; 3], i: usize) -> [f32; 3] {
    [planes[0][i], planes[1][i], planes[2][i]]
}
