//! The zoom, its levels, and edits.

use haarmonic::affine::{ImageRoute, Kernel, WaveletImage, Zoom, ZoomTargets, ZoomWindow};
use haarmonic::haar::Keep;

use crate::input::Input;
use crate::measure::psnr;
use crate::plain::Plain;
use crate::support::Failure;
use crate::support::sheet::{Panel, Sheet};

/// Pixels across of a picture on a sheet, at most.
const SHOWN: usize = 400;

type Picture = WaveletImage<f32, 3>;

/// Planes as a panel, made smaller by a zoom where they are large.
fn panel(planes: &[Vec<f32>; 3], side: usize, caption: &[String]) -> Result<Option<Panel>, Failure> {
    let shown = side.min(SHOWN);
    let image = Picture::from_pixels([side; 2], planes.each_ref().map(Vec::as_slice), Keep::Fraction(1.0))?;
    let [r, g, b] = image.zoom(ZoomWindow::WHOLE, [shown; 2])?.to_pixels();
    let byte = |x: f32| (255.0 * x.clamp(0.0, 1.0)).round() as u8;
    let pixels = (0..shown * shown).map(|i| [byte(r[i]), byte(g[i]), byte(b[i])]).collect();
    Ok(Some(Panel { caption: caption.to_vec(), width: shown, height: shown, pixels }))
}

fn of(image: &Picture, caption: &[String]) -> Result<Option<Panel>, Failure> {
    panel(&image.to_pixels(), image.size()[0], caption)
}

fn terms(image: &Picture) -> String {
    let area = image.size()[0] * image.size()[1];
    format!(
        "{} terms, {:.2} %, {:.0} kB",
        image.terms(),
        100.0 * image.terms() as f64 / area as f64,
        image.bytes() as f64 / 1e3
    )
}

/// Eight times what differs, around grey.
fn difference(a: &[Vec<f32>; 3], b: &[Vec<f32>; 3]) -> [Vec<f32>; 3] {
    std::array::from_fn(|c| a[c].iter().zip(&b[c]).map(|(a, b)| 0.5 + 8.0 * (a - b)).collect())
}

/// The picture with its window, the zoom by three methods, and what few terms make of it.
pub fn zoom(input: &Input, window: ZoomWindow, source: Keep) -> Result<Sheet, Failure> {
    let size = [input.side; 2];
    let image = input.compressed(source)?;
    let at = |route, keep| {
        let targets = if keep == Keep::Fraction(1.0) { ZoomTargets::All } else { ZoomTargets::Largest(keep) };
        Ok::<_, Failure>(Zoom::new(window, size, size)?.with_targets(targets).with_route(route).apply(&image)?)
    };
    let all = Keep::Fraction(1.0);
    let (ours, bands) = (at(ImageRoute::Wavelets, all)?, at(ImageRoute::Pixels, all)?);
    let mut plain = Plain::new(input.side);
    let peer: [_; 3] = [0, 1, 2].map(|c| plain.zoom(&image.channel(c).to_dense(), window, all));
    let peer = Picture::from_sparse(size, peer.each_ref())?.to_pixels();
    let [shown, exact] = [ours.to_pixels(), bands.to_pixels()];
    let first = vec![
        panel(&framed(&image, window), input.side, &["compressed picture and window".to_owned(), terms(&image)])?,
        panel(&shown, input.side, &["zoom, by wavelets".to_owned(), terms(&ours)])?,
        panel(
            &peer,
            input.side,
            &["zoom, decompressed, bilinear".to_owned(), format!("PSNR {:.1} dB", psnr(&shown, &peer))],
        )?,
        panel(&difference(&shown, &peer), input.side, &["8 x difference to that".to_owned()])?,
    ];
    let mut second = vec![panel(
        &difference(&shown, &exact),
        input.side,
        &["8 x difference to exact area resampling".to_owned(), format!("PSNR {:.1} dB", psnr(&shown, &exact))],
    )?];
    for percent in [10.0, 3.0, 1.0] {
        let few = at(ImageRoute::Wavelets, Keep::Fraction(percent / 100.0))?;
        second.push(of(&few, &[format!("largest {percent} % of the zoom"), terms(&few)])?);
    }
    Ok(Sheet::new("A zoom into a compressed picture, without decompression", &[first, second]))
}

/// The picture with the edge of a window drawn on it.
fn framed(image: &Picture, window: ZoomWindow) -> [Vec<f32>; 3] {
    let mut planes = image.to_pixels();
    let side = image.size()[0];
    let width = side.div_ceil(200) as f64 / side as f64;
    let maps = window.maps();
    for i in 0..side * side {
        let [x, y] = [i % side, i / side].map(|at| (at as f64 + 0.5) / side as f64);
        // How far inside of the window, in widths of the picture.
        let inside = [(x, maps[0]), (y, maps[1])].map(|(x, map)| {
            let (low, high) = (map.apply(0.0).min(map.apply(1.0)), map.apply(0.0).max(map.apply(1.0)));
            (x - low).min(high - x)
        });
        if (0.0..width).contains(&inside[0].min(inside[1])) {
            (0..3).for_each(|c| planes[c][i] = [0.95, 0.1, 0.1][c]);
        }
    }
    planes
}

/// Steps of the zoom, and the zoom of a picture that arrives in steps.
pub fn levels(input: &Input, window: ZoomWindow, source: Keep) -> Result<Sheet, Failure> {
    let (size, image) = ([input.side; 2], input.compressed(source)?);
    let zoom = Zoom::new(window, size, size)?;
    let (mut steps, mut sum) = (Vec::new(), Picture::zero(size)?);
    let last = input.side.ilog2() as usize;
    for (l, step) in zoom.levels(&image).enumerate() {
        sum = sum.plus(&step)?;
        if l + 6 > last && (last - l) % 2 == 1 || l == last {
            steps.push(of(&sum, &[format!("zoom, levels to {} pixels", 1 << l), terms(&sum)])?);
        }
    }
    let (mut arrived, mut seen) = (Picture::zero(size)?, Picture::zero(size)?);
    let mut stream = Vec::new();
    for (l, level) in image.levels().enumerate() {
        arrived = arrived.plus(&level)?;
        seen = seen.plus(&zoom.apply(&level)?)?;
        if l + 6 > last && (last - l) % 2 == 1 || l == last {
            stream.push(of(
                &seen,
                &[format!("picture, levels to {} pixels", 1 << l), format!("{} arrived", terms(&arrived))],
            )?);
        }
    }
    Ok(Sheet::new(
        "Coarse to fine: levels of the zoom, and the zoom of a picture that arrives by levels",
        &[steps, stream],
    ))
}

/// A compressed picture, edited as it is.
pub fn edits(input: &Input, source: Keep) -> Result<Sheet, Failure> {
    let (side, image) = (input.side, input.compressed(source)?);
    let samples = |f: &dyn Fn(f32) -> f32| (0..side).map(|k| f((k as f32 + 0.5) / side as f32)).collect::<Vec<f32>>();
    let flat = vec![1.0; side];
    let contrast = image.adjusted([1.6; 3], [-0.25; 3]);
    let kernel = Kernel::tent(side as f64 / 100.0)?;
    let blurred = image.convolve([&kernel, &kernel]);
    let streak = Kernel::boxed(side as f64 / 20.0)?;
    let moved = image.convolve([&streak, &Kernel::identity()]);
    // A dusk that comes from above, and a window in a mist.
    let dusk = image.adjusted([0.45, 0.40, 0.60], [0.02, 0.0, 0.06]);
    let gradient = WaveletImage::from_separable(&flat, &samples(&|y| (1.4 - 1.6 * y).clamp(0.0, 1.0)))?;
    let evening = dusk.blended(&image, &gradient)?;
    let hat = |centre: f32| move |x: f32| (2.0 - 7.0 * (x - centre).abs()).clamp(0.0, 1.0);
    let spot = WaveletImage::from_separable(&samples(&hat(0.42)), &samples(&hat(0.60)))?;
    let focus = image.blended(&blurred, &spot)?;
    let vignette = image.masked(&WaveletImage::from_separable(
        &samples(&|x| 1.0 - (2.0 * x - 1.0).powi(4)),
        &samples(&|y| 1.0 - (2.0 * y - 1.0).powi(4)),
    )?)?;
    let edges = [-1.0, 2.0, -1.0];
    let along = Kernel::from_taps(-1, &edges)?;
    let edged = image
        .convolve([&along, &Kernel::identity()])
        .plus(&image.convolve([&Kernel::identity(), &along]))?
        .adjusted([1.5; 3], [0.5; 3]);
    let mask = |mask: &WaveletImage<f32>| format!("mask of {} terms", mask.terms());
    let panels = [
        (&image, "compressed picture".to_owned()),
        (&contrast, "contrast: all terms, and the mean".to_owned()),
        (&blurred, format!("tent of {} taps, both axes", kernel.taps().len())),
        (&moved, format!("box of {} taps along x", streak.taps().len())),
        (&evening, format!("dusk from above, {}", mask(&gradient))),
        (&focus, format!("in focus in the middle, {}", mask(&spot))),
        (&vignette, "darker corners".to_owned()),
        (&edged, "second differences".to_owned()),
    ];
    let panels = panels.iter().map(|(image, caption)| of(image, &[caption.clone(), terms(image)]));
    let mut panels = panels.collect::<Result<Vec<_>, Failure>>()?;
    let second = panels.split_off(4);
    Ok(Sheet::new("Edits of a compressed picture, in the wavelet domain", &[panels, second]))
}
