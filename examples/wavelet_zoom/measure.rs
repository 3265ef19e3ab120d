//! Our time and that of the pixel methods, over the terms kept.

use haarmonic::Progress;
use haarmonic::affine::{
    ImageRoute, Propagation, PropagationRoute, PropagationScratch, PropagationSource, Targets, WaveletImage, Zoom,
    ZoomScratch, ZoomTargets, ZoomWindow,
};
use haarmonic::haar::{Decomposition, Keep, SparseVector, Transform2d};
use serde_json::{Value, json};

use crate::input::Input;
use crate::plain::Plain;
use crate::support::Failure;
use crate::support::progress::Bar;
use crate::support::timer::Timer;

/// Rounds of all contenders in turn; the least time of each counts.
const ROUNDS: usize = 7;

/// One choice of terms, through one window.
pub struct Measured {
    snapped: bool,
    /// Percent of the terms, of the picture and of the zoom.
    kept: [f64; 2],
    terms: usize,
    /// Milliseconds of wavelets, bands, plain loops, and bands whose result stays as large as an image.
    times: [f64; 4],
    /// The route that the library would have chosen.
    route: ImageRoute,
    /// Against the plain method, the bands, and the zoom of all terms.
    psnr: [f64; 3],
}

impl Measured {
    pub const HEADER: [&str; 13] = [
        "window",
        "source %",
        "target %",
        "terms",
        "ours ms",
        "bands ms",
        "faster",
        "dense ms",
        "faster",
        "plain ms",
        "faster",
        "PSNR dB",
        "to all dB",
    ];

    pub fn cells(&self) -> Vec<String> {
        let [ours, bands, plain, dense] = self.times;
        let route = if self.route == ImageRoute::Wavelets { "" } else { " (pixels chosen)" };
        vec![
            format!("{}{route}", self.window()),
            format!("{}", self.kept[0]),
            format!("{}", self.kept[1]),
            self.terms.to_string(),
            format!("{ours:.2}"),
            format!("{bands:.2}"),
            format!("x{:.1}", bands / ours),
            format!("{dense:.2}"),
            format!("x{:.1}", dense / ours),
            format!("{plain:.1}"),
            format!("x{:.0}", plain / ours),
            format!("{:.1}", self.psnr[0]),
            format!("{:.1}", self.psnr[2]),
        ]
    }

    fn window(&self) -> &'static str {
        if self.snapped { "whole pixels" } else { "anywhere" }
    }

    pub fn report(&self) -> [Value; 3] {
        [("bands", 1), ("plain", 2), ("dense", 3)].map(|(method, at)| {
            json!({
                "method": method,
                "window": self.window(),
                "source_percent": self.kept[0],
                "target_percent": self.kept[1],
                "terms": self.terms,
                "ours_ms": self.times[0],
                "pixels_ms": self.times[at],
                "speedup": self.times[at] / self.times[0],
                "psnr_db": self.psnr[usize::from(at != 2)],
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
    let mut timers = [(); 4].map(|()| Timer::default());
    let mut peer = Dense::new(image)?;
    let (mut results, mut plain) = ([None, None], Plain::new(side));
    let dense = [0, 1, 2].map(|c| image.channel(c).to_dense());
    let mut channels: [SparseVector<f32>; 3] = Default::default();
    for _ in 0..ROUNDS {
        results[0] = Some(timers[0].time(|| ours.apply_with(image, &mut scratch))?);
        results[1] = Some(timers[1].time(|| bands.apply_with(image, &mut scratch))?);
        timers[2].time(|| {
            (0..3).for_each(|c| channels[c] = plain.zoom(&dense[c], window, target));
        });
        timers[3].time(|| peer.zoom(&dense, window));
    }
    let plain = WaveletImage::from_sparse(size, channels.each_ref())?.to_pixels();
    let shown = results.map(|result| result.map_or_else(Default::default, |image| image.to_pixels()));
    let [ours, bands] = &shown;
    let percent = [source, target].map(|keep| 100.0 * keep.of(area) as f64 / area as f64);
    Ok(Measured {
        snapped,
        kept: percent.map(|percent| (percent * 1000.0).round() / 1000.0),
        terms: image.terms(),
        times: timers.map(|timer| timer.least()),
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

/// Decompression and the bands of [`Propagation`], whose result stays dense: no list is made and no term chosen.
struct Dense {
    plan: Propagation<f32>,
    source: PropagationSource<f32, 3>,
    all: Targets,
    transform: Transform2d<f32>,
    image: Vec<f32>,
    memory: Vec<f32>,
    out: [Vec<f32>; 3],
    scratch: PropagationScratch<f32>,
}

impl Dense {
    fn new(image: &WaveletImage<f32, 3>) -> Result<Self, Failure> {
        let (side, basis) = (image.size()[0], Decomposition::Standard);
        let channels = [0, 1, 2].map(|c| image.channel(c));
        let transform = Transform2d::new(side, side, basis)?;
        let plane = vec![0.0; side * side];
        Ok(Self {
            plan: Propagation::new(side, basis)?,
            source: PropagationSource::new(side, basis, channels.each_ref())?,
            all: Targets::all(side, basis)?,
            memory: vec![0.0; transform.scratch_len()],
            transform,
            out: [plane.clone(), plane.clone(), plane.clone()],
            image: plane,
            scratch: PropagationScratch::new(),
        })
    }

    /// The source has its pixels already: what it takes to make them is done beside it.
    fn zoom(&mut self, coefs: &[Vec<f32>; 3], window: ZoomWindow) {
        let Self { plan, source, all, transform, image, memory, out, scratch } = self;
        coefs.iter().for_each(|coefs| transform.inverse(coefs, image, memory));
        let out = out.each_mut().map(Vec::as_mut_slice);
        plan.apply_by(PropagationRoute::Pixels, source, window.maps(), all, out, scratch);
    }
}
