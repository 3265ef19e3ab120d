//! How many couplings are not zero, against the size of the signal [Sun 2008, fig. 4.6].

use haarmonic::affine::{AffineMap, Nonzeros1d};
use serde_json::{Value, json};

use crate::args::Args;
use crate::support::axis::{Axis, Scale, number};
use crate::support::plot::{self, Chart, Look, Series};
use crate::support::sheet::{PAPER, Sheet};
use crate::support::table;
use crate::{Failure, pair};

/// Scales of the random maps: 1/LARGEST…LARGEST, evenly in the logarithm.
const LARGEST: f64 = 4.0;
/// Curves that are drawn in colour and tabulated.
const HIGHLIGHTED: usize = 7;
/// Of the picture, in pixels.
const WIDTH: usize = 1640;

/// The counts of every map and size.
pub struct Counts {
    sizes: Vec<usize>,
    curves: Vec<Curve>,
}

struct Curve {
    map: AffineMap,
    /// Wavelets with wavelets, as in the thesis.
    wavelets: Vec<usize>,
    /// With the scaling functions.
    all: Vec<usize>,
}

impl Counts {
    pub fn new(args: &Args) -> Result<Self, Failure> {
        let sizes: Vec<usize> = (3..=args.largest.ilog2()).map(|k| 1 << k).collect();
        let mut maps: Vec<AffineMap> = (0..args.maps).map(random).collect::<Result<_, _>>()?;
        // Near the identity the counts are largest; the last two are not random.
        maps.push(AffineMap::new(1.0 + 2e-6, 1.7e-6)?);
        maps.push(AffineMap::IDENTITY);
        let curves = maps.into_iter().map(|map| Curve::new(map, &sizes)).collect::<Result<_, _>>()?;
        Ok(Self { sizes, curves })
    }

    /// The largest count of each size next to the laws.
    pub fn table(&self) -> String {
        let rows: Vec<Vec<String>> = (0..self.sizes.len())
            .map(|k| {
                let n = self.sizes[k];
                let most = |of: fn(&Curve) -> &Vec<usize>| self.curves.iter().map(|c| of(c)[k]).max().unwrap_or(0);
                let (wavelets, all) = (most(|c| &c.wavelets), most(|c| &c.all));
                let mean = self.random().map(|c| c.wavelets[k]).sum::<usize>() as f64 / self.random().count() as f64;
                vec![
                    n.to_string(),
                    wavelets.to_string(),
                    law(n).to_string(),
                    format!("{:.2}", wavelets as f64 / n as f64),
                    all.to_string(),
                    format!("{mean:.0}"),
                    format!("{:.0}", bound(n)),
                    format!("{:.0}", pairs(n)),
                ]
            })
            .collect();
        let header = [
            "N",
            "most, wavelets only",
            "8N - (k+2)(k+4)",
            "most/N",
            "most, all functions",
            "mean of random maps",
            "N k + k^2",
            "2k(N-1) - k^2",
        ];
        table::format(&header, &rows)
            + "k = log2 N. The thesis bounds the overlapping pairs by N k + k^2; 2k(N-1) - k^2 is the most there can be.\n"
    }

    pub fn report(&self) -> Value {
        let curve =
            |c: &Curve| json!({ "s": c.map.scale(), "o": c.map.offset(), "wavelets": c.wavelets, "all": c.all });
        json!({ "sizes": self.sizes, "maps": self.curves.iter().map(curve).collect::<Vec<_>>() })
    }

    fn random(&self) -> impl Iterator<Item = &Curve> {
        self.curves[..self.curves.len() - 2].iter()
    }

    /// Plot A: counts; B: counts over N; C: the values of some.
    pub fn draw(&self) -> Sheet {
        let highlighted = self.highlighted();
        let curves = |value: &dyn Fn(usize, usize) -> f64| {
            let points = |c: &Curve| {
                self.sizes.iter().zip(&c.wavelets).map(|(&n, &count)| [n as f64, value(n, count)]).collect::<Vec<_>>()
            };
            let along =
                |f: &dyn Fn(usize) -> f64| self.sizes.iter().map(|&n| [n as f64, value(n, f(n) as usize)]).collect();
            let grey = Look { colour: [190, 192, 198], width: 1.0, ..Look::PALE };
            let mut series: Vec<Series> =
                self.random().map(|c| Series { look: grey, ..Series::curve("", 0, points(c)) }).collect();
            let most = Series::curve("most found: 8N − (k+2)(k+4)", 0, along(&|n| law(n) as f64));
            series.push(Series { look: Look::PALE, ..most });
            series.push(Series::law("thesis: Nk + k²", [4, 6], along(&bound)));
            series.push(Series::law("pairs: 2k(N−1) − k²", [16, 8], along(&pairs)));
            series.extend(highlighted.iter().enumerate().map(|(k, c)| Series::new(&name(c.map), k, points(c))));
            series
        };
        let chart = |title: &str, y: Axis, series: Vec<Series>| Chart {
            title: title.to_owned(),
            x: Axis::new("signal size N (k = log₂ N)", Scale::Log2),
            y,
            series,
            size: [WIDTH / 2, 640],
        };
        let a = chart(
            "A: couplings that are not zero (wavelets only)",
            Axis::new("number of couplings", Scale::Log10),
            curves(&|_, count| count as f64),
        );
        let b = chart(
            "B: the same, divided by N",
            Axis::between("number of couplings / N", Scale::Linear, 0.0, 12.0),
            curves(&|n, count| count as f64 / n as f64),
        );
        let mut legend: Vec<Series> = a.series.clone();
        if let Some(one) = legend.first_mut() {
            one.label = format!("one of {} random maps", self.random().count());
        }
        let legend = plot::legend(&legend, 3, WIDTH);
        Sheet::grid(&[vec![a.draw(), b.draw()], vec![legend], vec![self.values(&highlighted)]], PAPER)
    }

    fn values(&self, highlighted: &[&Curve]) -> Sheet {
        let row = |name: String, values: &mut dyn Iterator<Item = String>| [vec![name], values.collect()].concat();
        let header = row("s, o".to_owned(), &mut self.sizes.iter().map(|n| format!("N = {n}")));
        let mut rows: Vec<Vec<String>> =
            highlighted.iter().map(|c| row(name(c.map), &mut c.wavelets.iter().map(usize::to_string))).collect();
        rows.push(row("most found".into(), &mut self.sizes.iter().map(|&n| law(n).to_string())));
        rows.push(row("thesis: Nk + k²".into(), &mut self.sizes.iter().map(|&n| format!("{:.0}", bound(n)))));
        rows.push(row("pairs".into(), &mut self.sizes.iter().map(|&n| format!("{:.0}", pairs(n)))));
        plot::table("C: values of the coloured curves", &header, &rows, WIDTH)
    }

    /// The curve near the identity, and random ones from the densest to the sparsest.
    fn highlighted(&self) -> Vec<&Curve> {
        let mut random: Vec<&Curve> = self.random().collect();
        random.sort_by_key(|c| std::cmp::Reverse(c.wavelets.last().copied()));
        let count = (HIGHLIGHTED - 1).min(random.len());
        let mut chosen = vec![&self.curves[self.curves.len() - 2]];
        chosen.extend((0..count).map(|k| random[k * (random.len() - 1) / (count - 1).max(1)]));
        chosen
    }
}

impl Curve {
    fn new(map: AffineMap, sizes: &[usize]) -> Result<Self, Failure> {
        let mut curve = Self { map, wavelets: Vec::new(), all: Vec::new() };
        for &n in sizes {
            let [mut wavelets, mut all] = [0, 0];
            Nonzeros1d::new(n)?.all(map, |i, j, _| {
                all += 1;
                wavelets += usize::from(i > 0 && j > 0);
            });
            curve.wavelets.push(wavelets);
            curve.all.push(all);
        }
        Ok(curve)
    }
}

fn name(map: AffineMap) -> String {
    let [s, o] = [map.scale(), map.offset()];
    if (s - 1.0).abs() < 1e-3 {
        format!("s = 1 + {}, o = {}", number(s - 1.0), number(o))
    } else {
        format!("s = {s:.3}, o = {o:.3}").replace('-', "−")
    }
}

/// s evenly in the logarithm, o where the signal is in sight.
fn random(k: usize) -> haarmonic::Result<AffineMap> {
    let [u, v] = pair(k);
    let s = LARGEST.powf(2.0 * u - 1.0);
    AffineMap::new(s, v * (1.0 + s) - s)
}

/// The most that any map reaches, found near s = 1.
fn law(n: usize) -> usize {
    let k = n.ilog2() as usize;
    8 * n - (k + 2) * (k + 4)
}

/// The thesis' bound of overlapping pairs, which the non-zeros exceed at N = 32 and 64.
///
/// It lets an interval overlap w + 1 cells of size 1/w; it may overlap ⌈w⌉ + 1.
fn bound(n: usize) -> f64 {
    let k = f64::from(n.ilog2());
    n as f64 * k + k * k
}

/// The most pairs of wavelets that can overlap: a and b intervals in a row make at most a + b − 1 pairs, summed over
/// all levels.
fn pairs(n: usize) -> f64 {
    let k = f64::from(n.ilog2());
    2.0 * k * (n as f64 - 1.0) - k * k
}
