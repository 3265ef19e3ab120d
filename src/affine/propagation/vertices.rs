//! One source and many vertices, each with its maps and its own targets: coefficients, their inner products with a
//! transport, and the gradients of both.

use super::{Propagation, PropagationScratch, PropagationSource, TargetLists, Targets, planes_of};
use crate::affine::AffineMap;
use crate::error::check_length;
use crate::{Real, parallel};

/// Vertices that a task takes at a time.
const TOGETHER: usize = 64;
/// The most parts of a sum over vertices, and numbers of all parts.
const MOST_PARTS: usize = 64;
const MOST_SUMS: usize = 1 << 22;

/// What a thread has for its vertices.
struct Memory<T> {
    targets: Targets,
    planes: Vec<T>,
    scratch: PropagationScratch<T>,
}

impl<T: Real> Memory<T> {
    fn new(lists: &TargetLists) -> Self {
        Self { targets: lists.scratch(), planes: Vec::new(), scratch: PropagationScratch::new() }
    }

    /// The targets of a vertex, and room for C planes of them.
    fn of(&mut self, lists: &TargetLists, vertex: usize, channels: usize) {
        lists.set(vertex, &mut self.targets);
        self.planes.resize(channels * self.targets.len(), T::zero());
    }
}

impl<T: Real> Propagation<T> {
    /// L of many vertices, each at its own targets, in parallel: `out` holds, vertex by vertex, C planes of one value a
    /// target, so that plane c of vertex v begins at C·[`range`](TargetLists::range)(v).start + c times the length of
    /// its list.
    ///
    /// The same bits for any number of threads. What is allocated is the memory of each thread, none a vertex.
    ///
    /// # Panics
    /// As [`apply`](Self::apply), of the lists' side and basis; or if there is not a pair of maps a vertex, or
    /// `out.len()` is not C times that of the lists.
    #[track_caller]
    pub fn apply_lists<const C: usize>(
        &self,
        source: &PropagationSource<T, C>,
        maps: &[[AffineMap; 2]],
        lists: &TargetLists,
        out: &mut [T],
    ) {
        self.check_lists(maps, lists);
        self.check_source(source);
        check_length("lists of target coefficients", C * lists.len(), out.len());
        let count = maps.len().div_ceil(TOGETHER);
        let end = |task: usize| C * lists.end((task * TOGETHER).min(maps.len()));
        parallel::ragged(
            out,
            count,
            end,
            || Memory::new(lists),
            |task, mut out, memory| {
                for (vertex, &maps) in maps.iter().enumerate().skip(task * TOGETHER).take(TOGETHER) {
                    lists.set(vertex, &mut memory.targets);
                    let len = memory.targets.len();
                    let (here, rest) = std::mem::take(&mut out).split_at_mut(C * len);
                    out = rest;
                    self.apply(source, maps, &memory.targets, planes_of(here, len), &mut memory.scratch);
                }
            },
        );
    }

    /// Σ_t T_t L_t of each vertex and channel, T the transport of the vertex at its targets: what leaves a vertex when
    /// the light is propagated to it and is met there by a product of visibility and reflectance. L is never stored.
    ///
    /// Shapes: transport: one value an entry of the lists, whole images with [`TargetLists::all`]; out: one a vertex.
    /// In parallel, with the same bits for any number of threads; sums are in `f64`. What is allocated is the memory of
    /// each thread, an image or two.
    ///
    /// # Panics
    /// As [`apply_lists`](Self::apply_lists), or if the length of `transport` is not that of the lists, or of `out` not
    /// the number of vertices.
    ///
    /// # Example
    /// ```
    /// use haarmonic::affine::{AffineMap, Propagation, PropagationSource, TargetLists};
    /// use haarmonic::haar::Decomposition::Standard;
    /// let source = PropagationSource::from_pixels(2, Standard, [&[0.0, 4.0, 0.0, 8.0]])?;
    /// let plan = Propagation::new(2, Standard)?;
    /// // Two vertices see the light as it is; the first is met by its mean, the other by the columns' difference, too.
    /// let lists = TargetLists::new(2, Standard, &[0, 1, 3], &[0, 0, 1])?;
    /// let mut out = [[0.0]; 2];
    /// plan.inner_products(&source, &[[AffineMap::IDENTITY; 2]; 2], &lists, &[1.0, 1.0, 0.5], &mut out);
    /// assert_eq!(out, [[3.0], [3.0 - 0.5 * 3.0]]);
    /// # Ok::<(), haarmonic::Error>(())
    /// ```
    #[track_caller]
    pub fn inner_products<const C: usize>(
        &self,
        source: &PropagationSource<T, C>,
        maps: &[[AffineMap; 2]],
        lists: &TargetLists,
        transport: &[T],
        out: &mut [[T; C]],
    ) {
        self.check_lists(maps, lists);
        self.check_source(source);
        check_length("transport", lists.len(), transport.len());
        check_length("inner products", maps.len(), out.len());
        each_vertex(out, lists, |vertex, memory| {
            memory.of(lists, vertex, C);
            let (transport, len) = (&transport[lists.range(vertex)], memory.targets.len());
            let Memory { targets, planes, scratch } = memory;
            self.apply(source, maps[vertex], targets, planes_of(planes, len), scratch);
            std::array::from_fn(|c| dot(transport, &planes[c * len..][..len]))
        });
    }

    /// The transpose of [`apply_lists`](Self::apply_lists): the gradient of a loss J in the coefficients of the source,
    /// summed over all vertices, from `cotangent` = ∂J/∂L in the shape of what that gives.
    ///
    /// ```math
    /// ∂J/∂F_i = Σ_v Σ_k D_ik(v) ∂J/∂L_k(v)
    /// ```
    ///
    /// Shapes: out: C planes of `source_side`² coefficients, overwritten. In parallel; vertices are summed in `f64`, in
    /// parts that depend on their number alone and are added in order, so that the bits are the same for any number of
    /// threads. What is allocated is the parts, of at most 32 MB where one image has less, and the memory of each
    /// thread.
    ///
    /// # Panics
    /// As [`apply_lists`](Self::apply_lists), of the cotangent; or if a length of `out` is not `source_side`².
    #[track_caller]
    pub fn adjoint_lists<const C: usize>(
        &self,
        maps: &[[AffineMap; 2]],
        lists: &TargetLists,
        cotangent: &[T],
        out: [&mut [T]; C],
    ) {
        check_length("lists of cotangents", C * lists.len(), cotangent.len());
        self.sum_adjoints(maps, lists, out, |vertex, dense, image, sums: &mut [Vec<f64>; C], scratch| {
            let range = lists.range(vertex);
            let here = &cotangent[C * range.start..C * range.end];
            for (c, sum) in sums.iter_mut().enumerate() {
                scatter(lists, vertex, &here[c * range.len()..][..range.len()], dense);
                self.adjoint_pixels(maps[vertex], dense, image, scratch);
                sum.iter_mut().zip(&*image).for_each(|(sum, &g)| *sum += g.widen());
            }
        });
    }

    /// The transpose of [`inner_products`](Self::inner_products): as [`adjoint_lists`](Self::adjoint_lists), from
    /// `cotangent` = ∂J/∂out, one a vertex.
    ///
    /// Cost: one adjoint a vertex, whatever the number of channels.
    ///
    /// # Panics
    /// As [`inner_products`](Self::inner_products); or if a length of `out` is not `source_side`².
    #[track_caller]
    pub fn inner_products_adjoint<const C: usize>(
        &self,
        maps: &[[AffineMap; 2]],
        lists: &TargetLists,
        transport: &[T],
        cotangent: &[[T; C]],
        out: [&mut [T]; C],
    ) {
        check_length("transport", lists.len(), transport.len());
        check_length("cotangents", maps.len(), cotangent.len());
        self.sum_adjoints(maps, lists, out, |vertex, dense, image, sums: &mut [Vec<f64>; C], scratch| {
            scatter(lists, vertex, &transport[lists.range(vertex)], dense);
            self.adjoint_pixels(maps[vertex], dense, image, scratch);
            for (sum, factor) in sums.iter_mut().zip(cotangent[vertex]) {
                sum.iter_mut().zip(&*image).for_each(|(sum, &g)| *sum += factor.widen() * g.widen());
            }
        });
    }

    /// [`gradient`](Self::gradient) of every vertex in the scale and offset of its own maps, from `cotangent` = ∂J/∂L
    /// in the shape of what [`apply_lists`](Self::apply_lists) gives.
    ///
    /// In parallel, with the same bits for any number of threads.
    ///
    /// # Panics
    /// As [`apply_lists`](Self::apply_lists), of the cotangent; or if there is not one of `out` a vertex.
    #[track_caller]
    pub fn gradient_lists<const C: usize>(
        &self,
        source: &PropagationSource<T, C>,
        maps: &[[AffineMap; 2]],
        lists: &TargetLists,
        cotangent: &[T],
        out: &mut [[[f64; 2]; 2]],
    ) {
        self.check_lists(maps, lists);
        self.check_source(source);
        check_length("lists of cotangents", C * lists.len(), cotangent.len());
        check_length("gradients", maps.len(), out.len());
        each_vertex(out, lists, |vertex, Memory { targets, scratch, .. }| {
            lists.set(vertex, targets);
            let (start, len) = (C * lists.range(vertex).start, targets.len());
            let here = std::array::from_fn(|c| &cotangent[start + c * len..][..len]);
            self.gradient(source, maps[vertex], targets, here, scratch)
        });
    }

    /// [`gradient_lists`](Self::gradient_lists) of the [`inner_products`](Self::inner_products), from `cotangent` =
    /// ∂J/∂out, one a vertex.
    ///
    /// # Panics
    /// As [`inner_products`](Self::inner_products), of the cotangent too; or if there is not one of `out` a vertex.
    #[track_caller]
    pub fn inner_products_gradient<const C: usize>(
        &self,
        source: &PropagationSource<T, C>,
        maps: &[[AffineMap; 2]],
        lists: &TargetLists,
        (transport, cotangent): (&[T], &[[T; C]]),
        out: &mut [[[f64; 2]; 2]],
    ) {
        self.check_lists(maps, lists);
        self.check_source(source);
        check_length("transport", lists.len(), transport.len());
        check_length("cotangents", maps.len(), cotangent.len());
        check_length("gradients", maps.len(), out.len());
        each_vertex(out, lists, |vertex, memory| {
            memory.of(lists, vertex, C);
            let (transport, len) = (&transport[lists.range(vertex)], memory.targets.len());
            let Memory { targets, planes, scratch } = memory;
            for (c, factor) in cotangent[vertex].into_iter().enumerate() {
                planes[c * len..][..len].iter_mut().zip(transport).for_each(|(g, &t)| *g = factor * t);
            }
            let here = std::array::from_fn(|c| &planes[c * len..][..len]);
            self.gradient(source, maps[vertex], targets, here, scratch)
        });
    }

    #[track_caller]
    fn check_lists(&self, maps: &[[AffineMap; 2]], lists: &TargetLists) {
        check_length("pairs of maps", lists.vertices(), maps.len());
        check_length("side of the targets", self.side(), lists.side());
        self.check_basis(lists.decomposition());
    }

    /// Σ over the vertices of what `add` adds to the pixels of each channel, as coefficients of the source.
    #[track_caller]
    fn sum_adjoints<const C: usize>(
        &self,
        maps: &[[AffineMap; 2]],
        lists: &TargetLists,
        out: [&mut [T]; C],
        add: impl Fn(usize, &mut [T], &mut [T], &mut [Vec<f64>; C], &mut PropagationScratch<T>) + Sync,
    ) {
        self.check_lists(maps, lists);
        let (area, vertices) = (self.source_side().pow(2), maps.len());
        for plane in &out {
            check_length("gradient", area, plane.len());
        }
        let parts = (MOST_SUMS / (C.max(1) * area)).clamp(1, MOST_PARTS).min(vertices);
        let sums = parallel::map(parts, |part| {
            let mut sums: [Vec<f64>; C] = std::array::from_fn(|_| vec![0.0; area]);
            let (mut dense, mut image) = (vec![T::zero(); self.side().pow(2)], vec![T::zero(); area]);
            let mut scratch = PropagationScratch::new();
            for vertex in vertices * part / parts..vertices * (part + 1) / parts {
                if !lists.range(vertex).is_empty() {
                    add(vertex, &mut dense, &mut image, &mut sums, &mut scratch);
                }
            }
            sums
        });
        let mut scratch = PropagationScratch::new();
        for (c, out) in out.into_iter().enumerate() {
            for (i, g) in out.iter_mut().enumerate() {
                *g = T::of(sums.iter().map(|part| part[c][i]).sum());
            }
            self.adjoint_transform(out, &mut scratch);
        }
    }
}

/// Writes what `one` makes of every vertex, in parallel, with memory that each thread makes for itself.
fn each_vertex<T: Real, R: Send>(out: &mut [R], lists: &TargetLists, one: impl Fn(usize, &mut Memory<T>) -> R + Sync) {
    parallel::chunks(
        out,
        TOGETHER,
        || Memory::new(lists),
        |task, out, memory| {
            out.iter_mut().enumerate().for_each(|(at, out)| *out = one(task * TOGETHER + at, memory));
        },
    );
}

/// Writes the entries of a vertex where they belong in an image of zeros.
fn scatter<T: Real>(lists: &TargetLists, vertex: usize, entries: &[T], dense: &mut [T]) {
    dense.fill(T::zero());
    entries.iter().enumerate().for_each(|(at, &g)| dense[lists.index(vertex, at)] = g);
}

/// In eight sums of `f64`, so that lanes work side by side.
fn dot<T: Real>(a: &[T], b: &[T]) -> T {
    let mut sums = [0.0; 8];
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<8>(), b.as_chunks::<8>());
    for (a, b) in a.iter().zip(b) {
        for k in 0..8 {
            sums[k] += a[k].widen() * b[k].widen();
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a.widen() * b.widen()).sum();
    T::of(sums.iter().sum::<f64>() + rest)
}
