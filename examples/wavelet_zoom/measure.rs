//! Our time and that of the pixel methods, over the terms kept.

use haarmonic::Progress;
use haarmonic::affine::{ImageRoute, WaveletImage, Zoom, ZoomScratch, ZoomTargets, ZoomWindow};
use haarmonic::haar::{Keep, SparseVector};
use serde_json::{Value, json};

use crate::input::Input;
use crate::plain::Plain;
use crate::support::Failure;
use crate::support::progress::Bar;
use crate::support::timer::Timer;

/// Rounds of each contender; the median counts.
const ROUNDS: usize = 5;

/// One choice of terms, through one window.
pub struct Measured {
    snapped: bool,
    /// Percent of the terms, of the picture and of the zoom.
    kept: [f64; 2],
    terms: usize,
    /// Milliseconds of wavelets, bands and plain loops.
    times: [f64; 3],
    /// The route that the library would have chosen.
    route: ImageRoute,
    /// Against the plain method, the bands, and the zoom of all terms.
    psnr: [f64; 3],
}

impl Measured {
    pub const HEADER: [&str; 11] = [
        "window",
        "source %",
        "target %",
        "terms",
        "ours ms",
        "bands ms",
        "faster",
        "plain ms",
        "faster",
        "PSNR dB",
        "to all dB",
    ];

    pub fn cells(&self) -> Vec<String> {
        let [ours, bands, plain] = self.times;
        let route = if self.route == ImageRoute::Wavelets { "" } else { " (pixels chosen)" };
        vec![
            format!("{}{route}", self.window()),
            format!("{}", self.kept[0]),
            format!("{}", self.kept[1]),
            self.terms.to_string(),
            format!("{ours:.2}"),
            format!("{bands:.2}"),
            format!("x{:.1}", bands / ours),
            format!("{plain:.1}"),
            format!("x{:.0}", plain / ours),
            format!("{:.1}", self.psnr[0]),
            format!("{:.1}", self.psnr[2]),
        ]
    }

    fn window(&self) -> &'static str {
        if self.snapped { "whole pixels" } else { "anywhere" }
    }

    pub fn report(&self) -> [Value; 2] {
        [("bands", 1), ("plain", 2)].map(|(method, at)| {
            json!({
                "method": method,
                "window": self.window(),
                "source_percent": self.kept[0],
                "target_percent": self.kept[1],
                "terms": self.terms,
                "ours_ms": self.times[0],
                "pixels_ms": self.times[at],
                "speedup": self.times[at] / self.times[0],
                "psnr_db": self.psnr[2 - at],
                "psnr_to_all_db": self.psnr[2],
            })
        })
    }
}

/// Every choice of terms, through the window where it is and where it begins with a pixel.
pub fn all(input: &Input, free: ZoomWindow, sources: &[Keep], targets: &[Keep]) -> Result<Vec<Measured>, Failure> {
    let bar = Bar::new("zooms");
    let size = [input.side; 2];
    let (mut all, total) = (Vec::new(), 2 * sources.len() * targets.len());
    let whole = input.compressed(Keep::Fraction(1.0))?;
    for &source in sources {
        let image = input.compressed(source)?;
        for (snapped, window) in [(false, free), (true, free.snapped(size)?)] {
            let best = whole.zoom(window, size)?.to_pixels();
            for &target in targets {
                all.push(one(&image, window, [source, target], snapped, &best)?);
                bar.advance(all.len(), total);
            }
        }
    }
    bar.finish();
    Ok(all)
}

fn one(
    image: &WaveletImage<f32, 3>,
    window: ZoomWindow,
    [source, target]: [Keep; 2],
    snapped: bool,
    best: &[Vec<f32>; 3],
) -> Result<Measured, Failure> {
    let (size, side) = (image.size(), image.size()[0]);
    let area = side * side;
    let targets = if target.of(area) == area { ZoomTargets::All } else { ZoomTargets::Largest(target) };
    let zoom = Zoom::new(window, size, size)?.with_targets(targets);
    let mut scratch = ZoomScratch::new();
    let route = zoom.route(image, &mut scratch);
    let [ours, bands] = ImageRoute::ALL.map(|route| zoom.with_route(route));
    let mut timers = [(); 3].map(|()| Timer::default());
    let (mut results, mut plain) = ([None, None], Plain::new(side));
    let dense = [0, 1, 2].map(|c| image.channel(c).to_dense());
    let mut channels: [SparseVector<f32>; 3] = Default::default();
    for _ in 0..ROUNDS {
        results[0] = Some(timers[0].time(|| ours.apply_with(image, &mut scratch))?);
        results[1] = Some(timers[1].time(|| bands.apply_with(image, &mut scratch))?);
        timers[2].time(|| {
            (0..3).for_each(|c| channels[c] = plain.zoom(&dense[c], window, target));
        });
    }
    let plain = WaveletImage::from_sparse(size, channels.each_ref())?.to_pixels();
    let shown = results.map(|result| result.map_or_else(Default::default, |image| image.to_pixels()));
    let [ours, bands] = &shown;
    let percent = [source, target].map(|keep| 100.0 * keep.of(area) as f64 / area as f64);
    Ok(Measured {
        snapped,
        kept: percent.map(|percent| (percent * 1000.0).round() / 1000.0),
        terms: image.terms(),
        times: timers.map(|timer| timer.median()),
        route,
        psnr: [psnr(ours, &plain), psnr(ours, bands), psnr(ours, best)],
    })
}

/// Peak signal 1, over all channels, in dB; 999 where nothing differs.
pub fn psnr(a: &[Vec<f32>; 3], b: &[Vec<f32>; 3]) -> f64 {
    let squares = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| f64::from(a - b).powi(2));
    let mean = squares.sum::<f64>() / a.iter().map(Vec::len).sum::<usize>() as f64;
    if mean == 0.0 { 999.0 } else { -10.0 * mean.log10() }
}
