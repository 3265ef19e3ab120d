//! How long it takes to carry a light to a place, against the terms that are kept of source and target.

use haarmonic::affine::PropagationRoute;
use haarmonic::haar::{Decomposition, forward_2d};
use serde_json::{Value, json};

use crate::contenders::{Case, Dense, PLACES, Table, best_of, light, places};
use crate::support::Failure;
use crate::support::axis::{Axis, Scale};
use crate::support::plot::{self, Chart, Look, Marker, Series};
use crate::support::sheet::{INK, PAPER, Sheet};
use crate::support::table;

const BASIS: Decomposition = Decomposition::Standard;
const CHANNELS: usize = 3;
const ROUNDS: usize = 20;
/// Of the picture, in pixels.
const WIDTH: usize = 1640;
/// Of relative L2 differences: sums in f32 in other orders, measured 2e-7.
const TOLERANCE: f64 = 2e-6;

/// What is varied, in percent; the other is held.
#[derive(Clone, Copy, PartialEq)]
enum Along {
    Source,
    Target,
}

impl Along {
    fn percent(self) -> &'static [f64] {
        match self {
            Self::Source => &[0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0],
            Self::Target => &[1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0],
        }
    }

    /// Source and target terms kept, in percent, where this one is `percent`.
    fn kept(self, percent: f64) -> [f64; 2] {
        match self {
            Self::Source => [percent, 20.0],
            Self::Target => [1.0, percent],
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Source => "source",
            Self::Target => "target",
        }
    }
}

/// One chart.
struct Panel {
    side: usize,
    along: Along,
    settings: Vec<Setting>,
    /// Nanoseconds a place, whatever is kept.
    table: f64,
    dense: f64,
}

struct Setting {
    percent: f64,
    /// Nanoseconds a place of wavelets, pixels, look-ups and the engine's choice.
    times: [f64; 4],
    /// How often the engine picks each route.
    choices: [usize; 3],
}

/// All charts.
pub struct Times {
    panels: Vec<Panel>,
    /// The largest relative L2 difference of any contender from the wavelets, everything kept.
    difference: f64,
}

/// Measures everything.
pub fn measure() -> Result<Times, Failure> {
    let mut times = Times { panels: Vec::new(), difference: 0.0 };
    for side in [32, 64] {
        let pixels: Vec<Vec<f32>> = (0..CHANNELS).map(|c| light(side, c)).collect();
        let coefs = pixels.iter().map(|p| forward_2d(p, side, side, BASIS)).collect::<Result<Vec<_>, _>>()?;
        let (mut table, mut dense) = (Table::new(side, BASIS, &pixels), Dense::new(side));
        times.difference = times.difference.max(difference(side, &coefs, &mut table, &mut dense));
        for along in [Along::Source, Along::Target] {
            times.panels.push(Panel::measure(side, along, &coefs, &mut table, &mut dense));
        }
    }
    if !(times.difference < TOLERANCE) {
        return Err(format!("the routes differ by {:.1e}, more than {TOLERANCE:e}", times.difference).into());
    }
    Ok(times)
}

/// The largest relative L2 difference from the wavelets over all places.
fn difference(side: usize, coefs: &[Vec<f32>], table: &mut Table, dense: &mut Dense) -> f64 {
    let mut case = Case::<f32, CHANNELS>::new(side, BASIS, side * side, side * side);
    let mut out = vec![0.0; CHANNELS * side * side];
    let mut largest = 0.0f64;
    for maps in places() {
        case.places = vec![maps];
        case.run(Some(PropagationRoute::Wavelets));
        let expected = case.out.clone();
        let norm = |values: &mut dyn Iterator<Item = f32>| values.map(|v| f64::from(v).powi(2)).sum::<f64>().sqrt();
        let size = norm(&mut expected.iter().copied());
        let mut compare = |got: &[f32]| {
            let difference = norm(&mut got.iter().zip(&expected).map(|(a, b)| a - b)) / size;
            // NaN stays.
            largest = if difference <= largest { largest } else { difference };
        };
        for route in [PropagationRoute::Pixels, PropagationRoute::Lookups] {
            case.run(Some(route));
            compare(&case.out);
        }
        table.apply(maps, &mut out);
        compare(&out);
        dense.apply(coefs, maps, &mut out);
        compare(&out);
    }
    largest
}

impl Panel {
    /// All settings and both peers in turn.
    fn measure(side: usize, along: Along, coefs: &[Vec<f32>], table: &mut Table, dense: &mut Dense) -> Self {
        let terms = |percent: f64| ((side * side) as f64 * percent / 100.0).ceil() as usize;
        let mut cases: Vec<Case<f32, CHANNELS>> = (along.percent().iter())
            .map(|&percent| {
                let [source, target] = along.kept(percent).map(terms);
                Case::new(side, BASIS, source, target)
            })
            .collect();
        let (places, mut out) = (places(), vec![0.0; CHANNELS * side * side]);
        let routes = 4 * cases.len();
        let best = best_of(routes + 2, ROUNDS, |k| match k.checked_sub(routes) {
            None => cases[k / 4].run(PropagationRoute::ALL.get(k % 4).copied()),
            Some(0) => places.iter().for_each(|&maps| table.apply(maps, &mut out)),
            Some(_) => places.iter().for_each(|&maps| dense.apply(coefs, maps, &mut out)),
        });
        let setting = |(k, &percent): (usize, &f64)| Setting {
            percent,
            times: std::array::from_fn(|route| best[4 * k + route]),
            choices: cases[k].choices(),
        };
        let settings = along.percent().iter().enumerate().map(setting).collect();
        Self { side, along, settings, table: best[routes], dense: best[routes + 1] }
    }

    fn title(&self) -> String {
        match self.along {
            Along::Source => format!("{0} x {0}, 20 % of the target terms", self.side),
            Along::Target => format!("{0} x {0}, 1 % of the source terms", self.side),
        }
    }

    /// Where two routes are equally fast, straight lines between the logarithms: (percent, nanoseconds).
    fn crossings(&self, [a, b]: [PropagationRoute; 2]) -> Vec<[f64; 2]> {
        let between = |pair: &[Setting]| {
            let [from, to] = [0, 1].map(|k| (pair[k].times[a as usize] / pair[k].times[b as usize]).ln());
            let along = |from: f64, to: f64, t: f64| (from.ln() + t * (to.ln() - from.ln())).exp();
            let time = |t| along(pair[0].times[a as usize], pair[1].times[a as usize], t);
            ((from < 0.0) != (to < 0.0)).then(|| {
                let t = from / (from - to);
                [along(pair[0].percent, pair[1].percent, t), time(t)]
            })
        };
        self.settings.windows(2).filter_map(between).collect()
    }

    fn chart(&self) -> Chart {
        let points = |time: &dyn Fn(&Setting) -> f64| {
            self.settings.iter().map(|s| [s.percent, time(s) / 1e3]).collect::<Vec<_>>()
        };
        let route = |k: usize, name: &str| Series::new(name, k, points(&|s| s.times[k]));
        let crossings = self.crossings([PropagationRoute::Wavelets, PropagationRoute::Pixels]);
        let notes = crossings.iter().map(|[percent, _]| format!("equal at {percent:.0} %")).collect::<Vec<_>>();
        let crossings = crossings.into_iter().map(|[percent, time]| [percent, time / 1e3]).collect();
        let dark = Look { colour: INK, marker: Marker::Diamond, radius: 6.5, width: 0.0, dashes: [0, 0] };
        let series = vec![
            Series { look: Look::PALE, ..Series::curve("the engine's choice", 0, points(&|s| s.times[3])) },
            route(PropagationRoute::Wavelets as usize, "wavelets"),
            route(PropagationRoute::Pixels as usize, "pixels"),
            route(PropagationRoute::Lookups as usize, "look-ups"),
            Series::law("summed-area table, Haar", [16, 8], points(&|_| self.table)),
            Series::law("dense operator", [4, 6], points(&|_| self.dense)),
            Series { look: dark, ..Series::points("wavelets = pixels", 0, crossings) }.with_notes(notes),
        ];
        let ends = [self.along.percent()[0], 100.0];
        let (low, high) = if self.side == 32 { (0.3, 1000.0) } else { (1.0, 3000.0) };
        Chart {
            title: self.title(),
            x: Axis::between(
                &format!("{} terms kept, %", self.along.name()),
                Scale::Log10,
                ends[0] * 0.85,
                ends[1] * 1.18,
            ),
            y: Axis::between("µs for a place, three channels", Scale::Log10, low, high),
            series,
            size: [WIDTH / 2, 580],
        }
    }

    fn table(&self) -> String {
        let header =
            ["% kept", "wavelets", "pixels", "look-ups", "chosen", "to best", "it chose (wavelets/pixels/look-ups)"];
        let row = |s: &Setting| {
            let mut cells = vec![s.percent.to_string()];
            cells.extend(s.times.map(|t| format!("{:.2}", t / 1e3)));
            cells.push(format!("{:.2}", s.to_best()));
            cells.push(s.choices.map(|c| c.to_string()).join("/"));
            cells
        };
        let mut text = format!("{}; us a place\n", self.title());
        text += &table::format(&header, &self.settings.iter().map(row).collect::<Vec<_>>());
        let crossing = |names: &str, routes| {
            let at: Vec<String> = self.crossings(routes).iter().map(|[p, _]| format!("{p:.1} %")).collect();
            if at.is_empty() { String::new() } else { format!("; {names} cross at {}", at.join(", ")) }
        };
        let [wavelets, pixels, lookups] = PropagationRoute::ALL;
        text += &format!(
            "summed-area table {:.2}, dense operator {:.2}{}{}{}\n",
            self.table / 1e3,
            self.dense / 1e3,
            crossing("wavelets and pixels", [wavelets, pixels]),
            crossing("wavelets and look-ups", [wavelets, lookups]),
            crossing("pixels and look-ups", [pixels, lookups]),
        );
        text
    }

    fn report(&self) -> Value {
        let setting = |s: &Setting| {
            let [wavelets, pixels, lookups, chosen] = s.times;
            let [source, target] = self.along.kept(s.percent);
            json!({ "source_percent": source, "target_percent": target, "wavelets_ns": wavelets, "pixels_ns": pixels,
                "lookups_ns": lookups, "chosen_ns": chosen, "chosen_to_best": s.to_best(), "choices": s.choices })
        };
        let crossings: Vec<f64> = self
            .crossings([PropagationRoute::Wavelets, PropagationRoute::Pixels])
            .into_iter()
            .map(|[percent, _]| percent)
            .collect();
        json!({ "side": self.side, "along": self.along.name(), "summed_area_table_ns": self.table,
            "dense_operator_ns": self.dense, "wavelets_pixels_cross_at_percent": crossings,
            "settings": self.settings.iter().map(setting).collect::<Vec<_>>() })
    }
}

impl Setting {
    /// The engine's choice over the best of the routes.
    fn to_best(&self) -> f64 {
        self.times[3] / self.times[..3].iter().copied().fold(f64::INFINITY, f64::min)
    }
}

impl Times {
    pub fn table(&self) -> String {
        let panels: Vec<String> = self.panels.iter().map(Panel::table).collect();
        format!(
            "{}\nThe peers take the same time whatever is kept. All contenders agree to {:.0e} (relative L2).\n",
            panels.join("\n"),
            self.difference
        )
    }

    pub fn draw(&self) -> Sheet {
        let charts: Vec<Chart> = self.panels.iter().map(Panel::chart).collect();
        let mut rows: Vec<Vec<Sheet>> = charts.chunks(2).map(|pair| pair.iter().map(Chart::draw).collect()).collect();
        let notes = [
            format!("One light to one place after another, s between 1/2 and 2: {CHANNELS} channels together, f32,"),
            format!("standard basis, one thread; best of {ROUNDS} rounds of {PLACES} places."),
        ];
        rows.push(vec![plot::legend(charts.iter().take(1).flat_map(|chart| &chart.series), 4, WIDTH)]);
        rows.push(vec![plot::text(&notes, [WIDTH, 90])]);
        Sheet::grid(&rows, PAPER)
    }

    pub fn report(&self) -> Value {
        json!({ "channels": CHANNELS, "scalar": "f32", "basis": "standard", "places": PLACES,
            "largest_difference": self.difference,
            "panels": self.panels.iter().map(Panel::report).collect::<Vec<_>>() })
    }
}
