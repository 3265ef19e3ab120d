//! The passes under the distance tables, in integers. Everything hot is `#[inline(always)]`, so that it is compiled for
//! the vector unit of the caller.
//!
//! Derivation. A pixel is 2 wide, so that centres and edges are integers, and d the distance from a centre to the
//! nearest boundary between unlike pixels. The nearest point of the boundary within column x′ is V(x′) above or below
//! this row, odd, from the runs of equal pixels of that column; it is g(k) = max(0, 2|k| − 1) away along the row, k =
//! x − x′, if the strip of the column is meant with its two sides. With the vertical pieces of boundary in this row
//! itself,
//! ```math
//! d² = min(min_x′ g(x − x′)² + V(x′)², min_e (2|x − e|)²),   e the places of those pieces.
//! ```
//! It does not matter on which side of the boundary x′ lies: each candidate is a point of the boundary.
//!
//! Two ways to the minimum. Near candidates: for k = 1, 2, … the row shifted by k, in vectors, until nothing can be
//! nearer. Far ones: a column's strip is left through its nearer side, so min over k ≠ 0 is the lower envelope of the
//! parabolas (2(p − x′))² + V² at the two edges p = x ± ½ of the pixel, found in linear time as in [Meijster 2000].

use super::binary_map::BinaryMap;

/// What a table stores of a signed square (2d)².
pub(super) trait FromSquare: Copy + Send {
    fn of(square: i32) -> Self;
    /// The same, of a square below 2²⁴.
    fn of_small(square: i32) -> Self;
}

impl FromSquare for i32 {
    #[inline(always)]
    fn of(square: i32) -> Self {
        square
    }

    #[inline(always)]
    fn of_small(square: i32) -> Self {
        square
    }
}

/// The distance in pixels, rounded once: the root of an integer below 2²⁴ is, and so is one taken in `f64` and
/// narrowed, because 53 bits are more than 2·24 + 2.
impl FromSquare for f32 {
    #[inline(always)]
    fn of(square: i32) -> Self {
        let root = 0.5 * f64::from(square.abs()).sqrt() as f32;
        root.copysign(square as f32)
    }

    #[inline(always)]
    fn of_small(square: i32) -> Self {
        let square = square as f32;
        (0.5 * square.abs().sqrt()).copysign(square)
    }
}

/// The pixels of a step: whole vectors of 16-bit numbers of every machine.
pub(super) const STEP: usize = 16;

/// Shifts that are tried in vectors before the envelope is built.
const NEAR: usize = 64;

/// The shift after which a block gives up if nothing of it is nearer than DEEP.
const HOPELESS: usize = 17;
const DEEP: u16 = 96 * 96;

/// No boundary above or below: larger than any distance to one, and 2·height more does not overflow.
const NONE: u16 = 0x7fff;

/// The square of what is too far for 16 bits, or is not there.
const FAR: u16 = u16::MAX;

/// What lies around a map: an open border is no boundary, a closed one is a ring of zeros.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ring {
    Open,
    Zero,
}

/// The buffers of a map; they keep their memory from map to map.
#[derive(Debug, Clone, Default)]
pub(super) struct Buffers {
    /// Distances to the boundary above; then also below.
    vertical: Vec<u16>,
    below: Vec<u16>,
    /// This row's pixels and the row before, a STEP of margin around each.
    pixels: [Vec<u16>; 2],
    /// Squares of a row, with 0 where a boundary is met on coming from the left or from the right; FAR all around.
    from: [Vec<u16>; 2],
    near: Vec<u16>,
    squares: Vec<i32>,
    sites: Vec<Site>,
    edges: Vec<i32>,
}

/// A parabola of the envelope, and the first edge where it is the lowest.
#[derive(Debug, Clone, Copy, Default)]
struct Site {
    at: i32,
    square: i32,
    first: i32,
}

/// Before and after each row of [`Buffers::from`].
const MARGIN: usize = NEAR + STEP;

impl Buffers {
    pub(super) fn resize(&mut self, width: usize, height: usize) {
        let padded = width.next_multiple_of(STEP);
        self.vertical.resize(padded * height, 0);
        self.below.resize(padded, 0);
        self.pixels.iter_mut().for_each(|row| row.resize(padded + 2 * STEP, 0));
        self.from.iter_mut().for_each(|row| {
            row.clear();
            row.resize(padded + 2 * MARGIN, FAR);
        });
        self.near.resize(padded, 0);
        self.squares.resize(padded, 0);
    }

    /// Distances to the boundary above each pixel.
    #[inline(always)]
    pub(super) fn downwards(&mut self, width: usize, height: usize, ring: Ring, map: BinaryMap<'_>) {
        let padded = self.below.len();
        self.start(width, 0, ring, map);
        for y in 0..height {
            let [row, before] = &mut self.pixels;
            map.row(y * width, &mut row[STEP..][..width]);
            advance(&row[STEP..], &before[STEP..], &mut self.below);
            self.vertical[y * padded..][..padded].copy_from_slice(&self.below);
            self.pixels.swap(0, 1);
        }
    }

    /// Row after row from the last to the first: distances to the boundary below, then everything else. `out` is the
    /// whole table.
    #[inline(always)]
    pub(super) fn upwards<O: FromSquare>(
        &mut self,
        width: usize,
        ring: Ring,
        map: BinaryMap<'_>,
        out: &mut [O],
        bound: i32,
    ) {
        let padded = self.below.len();
        let height = out.len() / width;
        self.start(width, height - 1, ring, map);
        for y in (0..height).rev() {
            let [row, before] = &mut self.pixels;
            map.row(y * width, &mut row[STEP..][..width]);
            advance(&row[STEP..], &before[STEP..], &mut self.below);
            nearer(&mut self.vertical[y * padded..][..padded], &self.below);
            self.row(width, y, ring);
            write(&self.squares, &self.pixels[0][STEP..], bound, &mut out[y * width..][..width]);
            self.pixels.swap(0, 1);
        }
    }

    /// The row outside the map: zeros, or, if the border is no boundary, pixels like those of row y.
    #[inline(always)]
    fn start(&mut self, width: usize, y: usize, ring: Ring, map: BinaryMap<'_>) {
        self.below.fill(NONE);
        match ring {
            Ring::Zero => self.pixels[1].fill(0),
            Ring::Open => map.row(y * width, &mut self.pixels[1][STEP..][..width]),
        }
    }

    /// The squares of a row, from its pixels and its vertical distances; `i32::MAX` where there is no boundary.
    #[inline(always)]
    fn row(&mut self, width: usize, y: usize, ring: Ring) {
        let padded = self.below.len();
        let vertical = &self.vertical[y * padded..][..padded];
        prepare(width, ring, &mut self.pixels[0], vertical, &mut self.near, &mut self.from);
        let limit = width.min(NEAR);
        let mut unfinished = false;
        for at in (0..width).step_by(STEP) {
            unfinished |= near_block(at, limit, &self.from, &mut self.near) > known(width);
        }
        let squares = self.squares.as_chunks_mut::<STEP>().0.iter_mut();
        for (squares, near) in squares.zip(self.near.as_chunks::<STEP>().0) {
            for x in 0..STEP {
                squares[x] = if near[x] == FAR { i32::MAX } else { i32::from(near[x]) };
            }
        }
        if unfinished {
            self.far(width, y, ring);
        }
    }

    /// Finishes the runs of equal pixels in which a distance is longer than the near candidates reach.
    #[inline(never)]
    fn far(&mut self, width: usize, y: usize, ring: Ring) {
        let padded = self.below.len();
        let known = i32::from(known(width));
        let mut start = 0;
        while start < width {
            let pixels = &self.pixels[0][STEP..][..width];
            let class = pixels[start];
            let count = pixels[start..].iter().take_while(|&&c| c == class).count();
            let end = start + count;
            let border = ring == Ring::Zero && class == 1;
            let ends = [start > 0 || border, end < width || border];
            if self.squares[start..end].iter().any(|&square| square > known) {
                let vertical = &self.vertical[y * padded + start..][..count];
                envelope(vertical, ends, &mut self.sites, &mut self.edges);
                finish(vertical, ends, &self.edges, &mut self.squares[start..end]);
            }
            start = end;
        }
    }
}

/// The largest square that the near candidates are sure of.
#[inline(always)]
fn known(width: usize) -> u16 {
    // In a narrow map they are all there is.
    if width <= NEAR { FAR - 1 } else { (2 * NEAR as u16 + 1).pow(2) }
}

/// All ones where it is so.
#[inline(always)]
fn mask(it_is: bool) -> u16 {
    u16::from(it_is).wrapping_neg()
}

/// One row further: distances grow by a pixel, or start anew behind a change. What is not there stays so.
#[inline(always)]
fn advance(row: &[u16], before: &[u16], distance: &mut [u16]) {
    let distance = distance.as_chunks_mut::<STEP>().0;
    let (row, before) = (row.as_chunks::<STEP>().0, before.as_chunks::<STEP>().0);
    let (row, before) = (&row[..distance.len()], &before[..distance.len()]);
    for k in 0..distance.len() {
        let (row, before, mut next) = (row[k], before[k], distance[k]);
        for x in 0..STEP {
            let same = mask(row[x] == before[x]);
            next[x] = ((next[x] + 2).min(NONE) & same) | (1 & !same);
        }
        distance[k] = next;
    }
}

#[inline(always)]
fn nearer(above: &mut [u16], below: &[u16]) {
    for (above, below) in above.as_chunks_mut::<STEP>().0.iter_mut().zip(below.as_chunks::<STEP>().0) {
        (0..STEP).for_each(|x| above[x] = above[x].min(below[x]));
    }
}

/// A row of the table: squares, no larger than `bound`, negative where the pixel is 0. Squares and pixels are padded to
/// whole steps.
#[inline(always)]
fn write<O: FromSquare>(squares: &[i32], pixels: &[u16], bound: i32, out: &mut [O]) {
    let (squares, pixels) = (squares.as_chunks::<STEP>().0, pixels.as_chunks::<STEP>().0);
    for ((squares, pixels), out) in squares.iter().zip(pixels).zip(out.chunks_mut(STEP)) {
        let mut signed = [0; STEP];
        for x in 0..STEP {
            let sign = i32::from(pixels[x]) - 1;
            signed[x] = (squares[x].min(bound) ^ sign) - sign;
        }
        let step = if bound < 1 << 24 { signed.map(O::of_small) } else { signed.map(O::of) };
        out.copy_from_slice(&step[..out.len()]);
    }
}

/// Squares of the vertical distances, and the two rows of near candidates.
#[inline(always)]
fn prepare(
    width: usize,
    ring: Ring,
    pixels: &mut [u16],
    vertical: &[u16],
    near: &mut [u16],
    [left, right]: &mut [Vec<u16>; 2],
) {
    // No change at the two ends: what is there is the ring's.
    let ends = [pixels[STEP], pixels[STEP + width - 1]];
    (pixels[STEP - 1], pixels[STEP + width]) = (ends[0], ends[1]);
    for at in (0..near.len()).step_by(STEP) {
        let chunk = |from: &[u16], start: usize| -> [u16; STEP] { *from[start..].first_chunk().expect("padded") };
        let [before, here, after] = [STEP - 1, STEP, STEP + 1].map(|shift| chunk(pixels, at + shift));
        let vertical = chunk(vertical, at);
        let mut squares = [[0; STEP]; 3];
        for x in 0..STEP {
            let square = vertical[x].wrapping_mul(vertical[x]) | mask(vertical[x] > 255);
            // A pixel to the left of the one that looks has its near side on the right.
            squares[0][x] = square & mask(here[x] == after[x]);
            squares[1][x] = square & mask(here[x] == before[x]);
            squares[2][x] = square;
        }
        left[MARGIN + at..][..STEP].copy_from_slice(&squares[0]);
        right[MARGIN + at..][..STEP].copy_from_slice(&squares[1]);
        near[at..][..STEP].copy_from_slice(&squares[2]);
    }
    near[width..].fill(0);
    let border = ends.map(|pixel| if ring == Ring::Zero && pixel == 1 { 0 } else { FAR });
    for row in [&mut *left, &mut *right] {
        row[MARGIN + width..][..STEP].fill(FAR);
    }
    (left[MARGIN - 1], right[MARGIN + width]) = (border[0], border[1]);
}

/// The minimum over the candidates up to `limit` pixels away; returns the largest of the block.
#[inline(always)]
fn near_block(at: usize, limit: usize, [left, right]: &[Vec<u16>; 2], near: &mut [u16]) -> u16 {
    let near: &mut [u16; STEP] = near[at..].first_chunk_mut().expect("padded");
    let mut best = *near;
    let mut largest = FAR;
    let (left, right) = (&left[at + MARGIN - NEAR..][..STEP + NEAR], &right[at + MARGIN..][..STEP + NEAR]);
    for k in 1..=limit {
        let left: &[u16; STEP] = left[NEAR - k..].first_chunk().expect("inside the margin");
        let right: &[u16; STEP] = right[k..].first_chunk().expect("inside the margin");
        let away = (2 * k as u16 - 1).pow(2);
        for x in 0..STEP {
            best[x] = best[x].min(left[x].min(right[x]).saturating_add(away));
        }
        if k % 4 == 1 || k == limit {
            largest = best.iter().fold(0, |a, &b| a.max(b));
            let sure = (2 * k as u16 + 1).pow(2);
            if largest <= sure {
                break;
            }
            // Deep inside a run the envelope will be wanted in any case: leave the block to it.
            if k == HOPELESS && best.iter().fold(FAR, |a, &b| a.min(b)) > DEEP {
                best = [FAR; STEP];
                largest = FAR;
                break;
            }
        }
    }
    *near = best;
    largest
}

/// min_u (2(j − u) − 1)² + V(u)² at the edges j = 0 … n of a run of n pixels.
fn envelope(vertical: &[u16], ends: [bool; 2], sites: &mut Vec<Site>, edges: &mut Vec<i32>) {
    let count = vertical.len() as i32;
    // Farther than the ends of the run is of no use.
    let useful = match ends {
        [true, true] => count,
        [false, false] => i32::from(NONE),
        _ => 2 * count,
    };
    sites.clear();
    for (at, &v) in (0..).zip(vertical) {
        let v = i32::from(v);
        if v >= useful || v >= i32::from(NONE) {
            continue;
        }
        let mut site = Site { at, square: v * v, first: 0 };
        while sites.last().is_some_and(|top| top.square(top.first) > site.square(top.first)) {
            sites.pop();
        }
        if let Some(top) = sites.last() {
            // (2(j − u) − 1)² + U² ≤ (2(j − v) − 1)² + V²  ⇔  j ≤ ((V² − U²)/4 + v² − u² + v − u)/(2(v − u));
            // not negative, because u wins at its first edge. Odd squares differ by multiples of 8.
            let (u, v) = (top.at, site.at);
            let numerator = (site.square - top.square) / 4 + (v - u) * (v + u + 1);
            site.first = (numerator as u32 / (2 * (v - u)) as u32) as i32 + 1;
        }
        if site.first <= count {
            sites.push(site);
        }
    }
    edges.clear();
    edges.resize(vertical.len() + 1, i32::MAX);
    let mut end = edges.len();
    for site in sites.iter().rev() {
        for j in site.first as usize..end {
            edges[j] = site.square(j as i32);
        }
        end = site.first as usize;
    }
}

impl Site {
    #[inline(always)]
    fn square(&self, edge: i32) -> i32 {
        let along = 2 * (edge - self.at) - 1;
        along * along + self.square
    }
}

/// The least of a pixel's own column, the envelope at its two edges, and the ends of its run.
fn finish(vertical: &[u16], ends: [bool; 2], edges: &[i32], squares: &mut [i32]) {
    let count = squares.len();
    let (vertical, edges) = (&vertical[..count], &edges[..count + 1]);
    for x in 0..count {
        let own = if vertical[x] == NONE { i32::MAX } else { i32::from(vertical[x]).pow(2) };
        let end = |there: bool, pixels: usize| if there { (2 * pixels as i32 + 1).pow(2) } else { i32::MAX };
        let [start, stop] = [end(ends[0], x), end(ends[1], count - 1 - x)];
        squares[x] = own.min(edges[x]).min(edges[x + 1]).min(start).min(stop);
    }
}
