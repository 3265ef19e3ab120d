//! Which way round faces are wound.
//!
//! Faces are joined along edges that two of them share, by the places of their corners. Neighbours agree where they run
//! along the edge in opposite directions. In a surface that is closed and orientable all faces can be made to agree, in
//! two ways; the given normals or the sign of the volume say which.

use nalgebra::Vector3;

use super::sides::buckets;
use crate::io::count::{Count, plural};
use crate::io::report::Report;

/// No face.
const NONE: u32 = u32::MAX;

/// The least volume that says where the outside is, as a share of area × radius: far more than rounding to `f32` makes.
const LEAST_VOLUME: f64 = 1.0 / (1 << 20) as f64;

/// How many solid angles and pairs of boxes are looked at to find out what is inside what.
const MOST_TESTS: u64 = 1 << 27;

/// The faces whose winding is judged, and what is known of them.
pub(super) struct Faces<'a> {
    pub(super) positions: &'a [Vector3<f32>],
    pub(super) normals: Option<&'a [Vector3<f32>]>,
    pub(super) welded: &'a [u32],
    pub(super) faces: &'a [[u32; 3]],
    /// Faces that are left out: the second and further of the same corners, and those there both ways round.
    pub(super) skipped: &'a [bool],
}

/// The edges of a set of faces: the ends, the face, whether it runs from the lesser end to the greater.
type Edge = (u64, u32, bool);

/// Faces joined along edges.
struct Surface {
    faces: Vec<u32>,
    /// Every edge has exactly two faces.
    closed: bool,
    /// All faces can be made to agree.
    orientable: bool,
    /// Six times the volume, twice the area, after all faces were made to agree with the first.
    volume: f64,
    area: f64,
    /// The area of those that were turned for it.
    turned_area: f64,
    /// How the given normals agree with the faces, as they are and after they were made to agree; zero without any.
    agreement: [f64; 2],
    has_normals: bool,
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Surface {
    fn is_mixed(&self) -> bool {
        self.turned_area > 0.0
    }

    /// Whether its volume has a sign.
    fn is_solid(&self) -> bool {
        self.volume.abs() / 6.0 > LEAST_VOLUME * 0.5 * self.area * (self.high - self.low).norm()
    }

    fn box_holds(&self, other: &Self) -> bool {
        self.low.zip_fold(&other.low, true, |all, a, b| all && a <= b)
            && self.high.zip_fold(&other.high, true, |all, a, b| all && a >= b)
    }
}

/// What [`Winding::Repair`](crate::io::Winding::Repair) turns: one entry a face. Warns of that, and of what stays as it
/// is.
pub(super) fn repair(given: &Faces<'_>, report: &mut Report) -> Vec<bool> {
    let mut plan = Plan::new(given);
    plan.find_surfaces();
    plan.decide(report);
    plan.turned
}

/// What is to be done about a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Verdict {
    Keep,
    /// Its faces agree with each other afterwards; with `flip` as the first one did not.
    Mixed {
        flip: bool,
    },
    /// All of it is turned.
    Inward,
    /// It is wound inwards, others are inside it, and it stays.
    AroundOthers,
    /// Its faces disagree, and it stays.
    Unclear,
}

/// What there is to say.
#[derive(Default)]
struct Findings {
    /// Faces that were turned.
    mixed: Count,
    inward: Count,
    inward_surfaces: usize,
    /// Surfaces that stay.
    around_others: Count,
    unclear: Count,
}

impl Findings {
    fn warn(self, report: &mut Report) {
        self.mixed.warn(report, |n| {
            let n = plural(n, "triangle of a closed surface was", "triangles of closed surfaces were");
            format!("{n} wound against the others; turned (unless Winding::Keep is asked for)")
        });
        let surfaces = plural(self.inward_surfaces, "closed surface is", "closed surfaces are");
        self.inward.warn(report, |n| {
            let n = plural(n, "triangle", "triangles");
            format!(
                "{surfaces} wound inwards; {n} turned outwards (for a room that is seen from inside ask for Winding::Keep)"
            )
        });
        self.around_others.warn(report, |n| {
            let n = plural(n, "closed surface is", "closed surfaces are");
            format!(
                "{n} wound inwards around others: taken for a room that is seen from inside and left so; if it is inside \
                 out, turn its faces in the program it comes from"
            )
        });
        self.unclear.warn(report, |n| {
            let n = plural(
                n,
                "surface that is open or has one side only has",
                "surfaces that are open or have one side only have",
            );
            format!(
                "{n} neighbouring triangles that are wound against each other; left so: vertex normals are wrong along \
                 their edges. Make the winding agree, or give normals"
            )
        });
    }
}

struct Plan<'a> {
    given: &'a Faces<'a>,
    edges: Vec<Edge>,
    /// The surface of each face.
    surface_of: Vec<u32>,
    surfaces: Vec<Surface>,
    /// Whether a face was turned to agree with the first of its surface; in the end, whether it is to be turned.
    turned: Vec<bool>,
    tests: u64,
}

impl<'a> Plan<'a> {
    fn new(given: &'a Faces<'a>) -> Self {
        let corner = |f: u32, k: u32| given.welded[given.faces[f as usize][k as usize % 3] as usize];
        let lesser = |e: u32| corner(e / 3, e % 3).min(corner(e / 3, e % 3 + 1));
        let (order, starts) = buckets(given.welded.len(), 3 * given.faces.len(), lesser);
        let edge = |&e: &u32| {
            let (f, from, to) = (e / 3, corner(e / 3, e % 3), corner(e / 3, e % 3 + 1));
            (u64::from(from.min(to)) << 32 | u64::from(from.max(to)), f, from < to)
        };
        let judged = |e: &&u32| !given.skipped[**e as usize / 3];
        let mut edges: Vec<Edge> = Vec::with_capacity(order.len());
        for bucket in starts.windows(2) {
            let start = edges.len();
            edges.extend(order[bucket[0]..bucket[1]].iter().filter(judged).map(edge));
            edges[start..].sort_unstable();
        }
        let n = given.faces.len();
        Self { given, edges, surface_of: vec![NONE; n], surfaces: Vec::new(), turned: vec![false; n], tests: 0 }
    }

    /// Joins faces along the edges that two of them share.
    fn find_surfaces(&mut self) {
        let n = self.given.faces.len();
        // Per face, up to three neighbours and whether they disagree.
        let mut neighbours = vec![[(NONE, false); 3]; n];
        let mut add = |a: u32, b: u32, disagree: bool| {
            if let Some(slot) = neighbours[a as usize].iter_mut().find(|s| s.0 == NONE) {
                *slot = (b, disagree);
            }
        };
        for pair in self.edges.chunk_by(|a, b| a.0 == b.0).filter(|c| c.len() == 2) {
            add(pair[0].1, pair[1].1, pair[0].2 == pair[1].2);
            add(pair[1].1, pair[0].1, pair[0].2 == pair[1].2);
        }
        for start in (0..n).filter(|&f| !self.given.skipped[f]) {
            if self.surface_of[start] != NONE {
                continue;
            }
            let id = self.surfaces.len() as u32;
            let (mut faces, mut orientable) = (vec![start as u32], true);
            self.surface_of[start] = id;
            let mut next = 0;
            while let Some(&f) = faces.get(next) {
                next += 1;
                for &(g, disagree) in neighbours[f as usize].iter().filter(|s| s.0 != NONE) {
                    let turned = self.turned[f as usize] != disagree;
                    if self.surface_of[g as usize] == NONE {
                        self.surface_of[g as usize] = id;
                        self.turned[g as usize] = turned;
                        faces.push(g);
                    } else {
                        orientable &= self.turned[g as usize] == turned;
                    }
                }
            }
            let surface = self.measure(faces, orientable);
            self.surfaces.push(surface);
        }
        self.find_borders();
    }

    /// A surface is open if one of its edges does not have two of its faces. Edges that several surfaces share count
    /// for each of them.
    fn find_borders(&mut self) {
        let mut around: Vec<(u32, bool)> = Vec::new();
        for edge in self.edges.chunk_by(|a, b| a.0 == b.0).filter(|c| c.len() != 2) {
            around.clear();
            around.extend(edge.iter().map(|e| (self.surface_of[e.1 as usize], e.2 != self.turned[e.1 as usize])));
            around.sort_unstable();
            for same in around.chunk_by(|a, b| a.0 == b.0) {
                let surface = &mut self.surfaces[same[0].0 as usize];
                surface.closed &= same.len() == 2;
                surface.orientable &= same.len() != 2 || same[0].1 != same[1].1;
            }
        }
    }

    fn measure(&self, faces: Vec<u32>, orientable: bool) -> Surface {
        let corners = |f: u32| self.given.faces[f as usize].map(|i| self.given.positions[i as usize].cast::<f64>());
        let from = corners(faces[0])[0];
        let mut surface = Surface {
            faces,
            closed: true,
            orientable,
            volume: 0.0,
            area: 0.0,
            turned_area: 0.0,
            agreement: [0.0; 2],
            has_normals: false,
            low: from,
            high: from,
        };
        for &f in &surface.faces {
            let [a, b, c] = corners(f);
            for p in [a, b, c] {
                surface.low = surface.low.inf(&p);
                surface.high = surface.high.sup(&p);
            }
            let sign = if self.turned[f as usize] { -1.0 } else { 1.0 };
            let area = (b - a).cross(&(c - a));
            surface.volume += sign * (a - from).dot(&area);
            surface.area += area.norm();
            surface.turned_area += if self.turned[f as usize] { area.norm() } else { 0.0 };
            if let Some(normals) = self.given.normals {
                for n in self.given.faces[f as usize].map(|i| normals[i as usize]) {
                    surface.has_normals |= n != Vector3::zeros();
                    let agreement = area.dot(&n.cast());
                    surface.agreement[0] += agreement;
                    surface.agreement[1] += sign * agreement;
                }
            }
        }
        surface
    }

    /// What is to be done about a surface.
    fn judge(&mut self, id: usize) -> Verdict {
        let s = &self.surfaces[id];
        if !(s.closed && s.orientable) {
            let disagrees = s.is_mixed() || !s.orientable;
            return if disagrees && !s.has_normals { Verdict::Unclear } else { Verdict::Keep };
        }
        let [as_given, agreed] = s.agreement;
        if s.has_normals {
            // Only if the faces fit the normals better afterwards.
            let better = s.is_mixed() && agreed.abs() > as_given;
            return if better { Verdict::Mixed { flip: agreed < 0.0 } } else { Verdict::Keep };
        }
        // Something flat has no outside.
        if !s.is_solid() || !s.is_mixed() && s.volume > 0.0 {
            return Verdict::Keep;
        }
        let (inside, holds) = self.nesting(id);
        let s = &self.surfaces[id];
        match (s.is_mixed(), inside || holds) {
            (true, false) => Verdict::Mixed { flip: s.volume < 0.0 },
            // As most of it is.
            (true, true) => Verdict::Mixed { flip: 2.0 * s.turned_area > s.area },
            (false, false) => Verdict::Inward,
            (false, true) => {
                if inside {
                    Verdict::Keep
                } else {
                    Verdict::AroundOthers
                }
            }
        }
    }

    /// Turns each surface as it was judged, and warns.
    fn decide(&mut self, report: &mut Report) {
        let mut found = Findings::default();
        let place = |f: u32| format!("triangle {f}");
        for id in 0..self.surfaces.len() {
            let verdict = self.judge(id);
            if verdict == Verdict::Unclear {
                found.unclear.add(|| place(self.first_disagreeing(id)));
            }
            let faces = &self.surfaces[id].faces;
            if verdict == Verdict::AroundOthers {
                found.around_others.add(|| place(faces[0]));
            }
            for &f in faces {
                let turned = &mut self.turned[f as usize];
                *turned = match verdict {
                    Verdict::Mixed { flip } => *turned != flip,
                    Verdict::Inward => true,
                    _ => false,
                };
            }
            // In the order of the file, so that the first is the first.
            let mut turned: Vec<u32> = faces.iter().copied().filter(|&f| self.turned[f as usize]).collect();
            turned.sort_unstable();
            if verdict == Verdict::Inward {
                found.inward_surfaces += 1;
                turned.iter().for_each(|&f| found.inward.add(|| place(f)));
            } else {
                turned.iter().for_each(|&f| found.mixed.add(|| place(f)));
            }
        }
        found.warn(report);
    }

    /// The first face of a surface that disagrees with a neighbour.
    fn first_disagreeing(&self, id: usize) -> u32 {
        let pairs = self.edges.chunk_by(|a, b| a.0 == b.0).filter(|c| c.len() == 2 && c[0].2 == c[1].2);
        let own = pairs.filter(|c| self.surface_of[c[0].1 as usize] == id as u32);
        own.map(|c| c[0].1.max(c[1].1)).min().unwrap_or(self.surfaces[id].faces[0])
    }

    /// Whether a closed surface is inside another one, and whether another one is inside it; the latter, too, if that
    /// would take too long to find out.
    fn nesting(&mut self, id: usize) -> (bool, bool) {
        let (mut inside, mut holds) = (false, false);
        for other in 0..self.surfaces.len() {
            self.tests += 1;
            if self.tests > MOST_TESTS {
                return (false, true);
            }
            let (a, b) = (&self.surfaces[id], &self.surfaces[other]);
            if other == id || inside && holds {
                continue;
            }
            if !inside && b.closed && b.orientable && b.box_holds(a) {
                self.tests += b.faces.len() as u64;
                inside = self.is_inside(id, other);
            }
            let (a, b) = (&self.surfaces[id], &self.surfaces[other]);
            if !holds && a.box_holds(b) {
                self.tests += a.faces.len() as u64;
                holds = self.is_inside(other, id);
            }
        }
        (inside, holds)
    }

    /// Whether the first corner of surface `inner` is inside of `outer`: the solid angles of its faces add up to 4π.
    fn is_inside(&self, inner: usize, outer: usize) -> bool {
        let corners = |f: u32| self.given.faces[f as usize].map(|i| self.given.positions[i as usize].cast::<f64>());
        let from = corners(self.surfaces[inner].faces[0])[0];
        let angle = |&f: &u32| {
            let [a, b, c] = corners(f).map(|p| p - from);
            let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
            let sign = if self.turned[f as usize] { -1.0 } else { 1.0 };
            // Van Oosterom & Strackee 1983, half of the solid angle.
            let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
            sign * a.dot(&b.cross(&c)).atan2(below)
        };
        let half: f64 = self.surfaces[outer].faces.iter().map(angle).sum();
        half.abs() > std::f64::consts::PI
    }
}
