//! Frames of moving lamps by every route, their errors and their pictures.

use haarmonic::backend::near_field::{
    BakeSettings, PlanarLight, Relighter, Route, Settings, TargetSelection, Transport, ViewFactors,
};
use haarmonic::haar::Keep;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{Bvh, Comparison, Picture, ToneMap};
use serde_json::{Value, json};

use crate::args::Args;
use crate::scene::Scene;
use crate::support::progress::Bar;
use crate::support::sheet::{Panel, Sheet, heat};
use crate::support::timer::Timer;
use crate::support::{self, Failure, table};
use crate::truth;

/// What came of a route.
struct Outcome {
    method: String,
    route: &'static str,
    source: Keep,
    target: String,
    radiance: Vec<Vector3<f32>>,
    relight_ms: Option<f64>,
    set_ms: Option<f64>,
    /// Beside the transport.
    bytes: usize,
}

/// The bake that the command line asks for.
pub fn bake_settings(args: &Args) -> BakeSettings {
    BakeSettings { face_size: args.face, cells: args.order, samples: args.samples, ..BakeSettings::default() }
}

pub fn bake(args: &Args, scene: &Scene, settings: BakeSettings) -> Result<(Transport, f64), Failure> {
    let bar = Bar::new("bake");
    let (mesh, occluders, materials) = (&scene.mesh, scene.occluders.clone(), &scene.materials);
    let transport = if args.free_view {
        Transport::bake_view_free(mesh, occluders, materials, ViewFactors::default(), settings, &bar)?
    } else {
        Transport::bake(mesh, occluders, &scene.view, materials, settings, &bar)?
    };
    Ok((transport, bar.finish()))
}

pub fn run(args: &Args, scene: &Scene) -> Result<(), Failure> {
    let settings = bake_settings(args);
    let (transport, bake_s) = bake(args, scene, settings)?;
    let lights = scene.lights_at(1.0)?;
    let truth = truth::of_lamps(scene, &lights, args.truth_samples)?;
    let same_face = truth::of_cells(scene, &lights, &settings, args.order)?;
    let all = Keep::Fraction(1.0);
    let predicted = TargetSelection::constant_light(args.target);
    let asked: Vec<(&str, Route, Keep, TargetSelection<'_>)> = match args.route {
        Some(route) => vec![("as asked", route, args.source, predicted)],
        None => vec![
            ("everything kept", Route::Automatic, all, TargetSelection::Transport),
            ("few wavelets", Route::Automatic, args.source, TargetSelection::Transport),
            ("few wavelets", Route::Couplings, args.source, TargetSelection::All),
            ("few, few targets", Route::Couplings, args.source, predicted),
            ("few, few targets", Route::StoredCouplings, args.source, predicted),
            ("few, few targets", Route::CanonicalTable, args.source, predicted),
            ("few, few targets", Route::SummedArea, args.source, predicted),
        ],
    };
    let mut outcomes = Vec::new();
    for (method, route, source, targets) in asked {
        let settings =
            Settings { source_side: args.order, source_terms: source, targets, route, ..Settings::default() };
        outcomes.push(frames(args, scene, &transport, settings, method)?);
    }
    if args.route.is_none() {
        let radiance = truth::as_if_distant(scene, &lights)?.iter().map(|l| l.cast()).collect();
        let (method, route) = ("taken for distant".to_owned(), "environment");
        let target = "all".to_owned();
        outcomes.push(Outcome {
            method,
            route,
            source: all,
            target,
            radiance,
            relight_ms: None,
            set_ms: None,
            bytes: 0,
        });
    }
    let (mut rows, mut results) = (Vec::new(), Vec::new());
    let short: Vec<Vector3<f32>> = truth.iter().map(|l| l.cast()).collect();
    let db = |db: f64| if db.is_finite() { format!("{db:.1}") } else { "exact".to_owned() };
    let finite = |x: f64| x.is_finite().then_some(x);
    for outcome in &outcomes {
        let of_lamps = Comparison::new(&truth, &outcome.radiance)?;
        let of_cells = Comparison::new(&same_face, &outcome.radiance)?;
        let bytes = transport.bytes() + outcome.bytes;
        let per_second = outcome.relight_ms.map(|ms| truth.len() as f64 / ms * 1e3);
        let text = |x: Option<f64>, digits: usize| x.map_or("–".to_owned(), |x| format!("{x:.digits$}"));
        rows.push(vec![
            outcome.method.clone(),
            outcome.route.to_owned(),
            outcome.source.to_string(),
            outcome.target.clone(),
            db(of_lamps.psnr_db),
            db(of_cells.psnr_db),
            format!("{:.1e}", of_cells.rel_l2),
            text(outcome.relight_ms, 2),
            text(outcome.set_ms, 2),
            text(per_second.map(|x| x / 1e6), 2),
            format!("{:.1}", bytes as f64 / 1e6),
        ]);
        results.push(json!({
            "method": outcome.method,
            "route": outcome.route,
            "source": outcome.source.to_string(),
            "target": outcome.target,
            "vertices": truth.len(),
            "psnr_db": finite(of_lamps.psnr_db),
            "psnr_same_face_db": finite(of_cells.psnr_db),
            "rel_l2_same_face": of_cells.rel_l2,
            "relight_ms": outcome.relight_ms,
            "set_light_ms": outcome.set_ms,
            "bake_s": bake_s,
            "transport_bytes": bytes,
            "threads": rayon::current_num_threads(),
        }));
    }
    let header = [
        "method",
        "route",
        "source",
        "targets",
        "PSNR dB",
        "same face dB",
        "rel L2",
        "relight ms",
        "set light ms",
        "M vertices/s",
        "MB",
    ];
    println!(
        "\nbake {bake_s:.1} s, {:.1} MB, {} coefficients",
        transport.bytes() as f64 / 1e6,
        transport.stats().coefficients
    );
    println!("{}", table::format(&header, &rows));
    let sheet = sheet(args, scene, &transport, &short, &outcomes)?;
    args.folder.save("near_field.png", &sheet)?;
    println!("picture: near_field.png in {}", args.folder.path.display());
    let settings = json!({
        "mesh": scene.name, "texture": args.texture, "order": args.order, "face": args.face, "lights": args.lights,
        "frames": args.frames, "bake_s": bake_s,
    });
    support::write_report(&args.common, "near_field", settings, Value::Array(results))
}

/// Times frames of the lamps on their way; the last is where they arrive.
fn frames(
    args: &Args,
    scene: &Scene,
    transport: &Transport,
    settings: Settings<'_>,
    method: &str,
) -> Result<Outcome, Failure> {
    let mut relighter = Relighter::new(transport, settings)?;
    let mut radiance = vec![Vector3::zeros(); transport.vertices()];
    let (mut relight, mut set) = (Timer::default(), Timer::default());
    relighter.set_lights(&scene.lights_at(1.0)?)?;
    relighter.set_view(&scene.view)?;
    relighter.relight(&mut radiance);
    for frame in 1..=args.frames {
        let lights = scene.lights_at(frame as f64 / args.frames as f64)?;
        set.time(|| relighter.set_lights(&lights))?;
        relight.time(|| relighter.relight(&mut radiance));
    }
    let target = match settings.targets {
        TargetSelection::Predicted { keep, .. } => keep.to_string(),
        TargetSelection::Transport => "of the transport".to_owned(),
        TargetSelection::All => "all".to_owned(),
    };
    Ok(Outcome {
        method: method.to_owned(),
        route: relighter.routes()[0].name(),
        source: settings.source_terms,
        target,
        radiance,
        relight_ms: Some(relight.median()),
        set_ms: Some(set.median()),
        bytes: relighter.bytes() + relighter.table_bytes(),
    })
}

/// Truth, near and distant, as fig. 4.8; error maps; the lamp edited in two ways.
fn sheet(
    args: &Args,
    scene: &Scene,
    transport: &Transport,
    truth: &[Vector3<f32>],
    outcomes: &[Outcome],
) -> Result<Sheet, Failure> {
    let plan = Picture::new(&scene.mesh, &Bvh::new(&scene.mesh), &scene.camera, [args.size; 2], 3)?;
    let tone = ToneMap::with_white(bright(truth));
    let shown = |colours: &[Vector3<f32>]| -> Vec<[u8; 3]> {
        plan.shade(colours, |_| Vector3::repeat(0.03)).iter().map(|l| tone.apply(l)).collect()
    };
    let panel = |caption: Vec<String>, pixels| Some(Panel { caption, width: args.size, height: args.size, pixels });
    let mean = truth.iter().map(|l| f64::from(l.mean())).sum::<f64>() / truth.len() as f64;
    let (mut first, mut second) = (
        vec![panel(vec!["ground truth".to_owned(), "of the lamps themselves".to_owned()], shown(truth))],
        vec![panel(vec!["the lamp, as it hangs".to_owned()], lamp_picture(&scene.lights[0], args.size, &tone))],
    );
    let chosen: Vec<&Outcome> = match outcomes {
        [one] => vec![one],
        [exact, few, .., distant] => vec![exact, few, distant],
        _ => vec![],
    };
    for outcome in chosen {
        let compared = Comparison::new(truth, &outcome.radiance)?;
        let errors: Vec<Vector3<f32>> = truth
            .iter()
            .zip(&outcome.radiance)
            .map(|(a, b)| Vector3::repeat((a - b).abs().mean() * (1.0 / mean.max(1e-30)) as f32))
            .collect();
        first.push(panel(
            vec![
                format!("{}, {} of the lamp's wavelets", outcome.method, outcome.source),
                format!("PSNR {:.1} dB", compared.psnr_db),
            ],
            shown(&outcome.radiance),
        ));
        let map = plan.shade(&errors, |_| Vector3::zeros()).iter().map(|e| heat(e.x / 0.5)).collect();
        second.push(panel(
            vec!["its error: white is half of the mean".to_owned(), format!("rel. L² {:.1e}", compared.rel_l2)],
            map,
        ));
    }
    let mut rows = vec![first, second];
    rows.push(edited(args, scene, transport, &panel, &shown)?);
    let title = format!("Near-field relighting: {}, {} vertices", scene.name, truth.len());
    Ok(Sheet::new(&title, &rows))
}

/// The same scene with the lamp turned, squeezed, masked and lowered: no bake between.
fn edited(
    args: &Args,
    scene: &Scene,
    transport: &Transport,
    panel: &impl Fn(Vec<String>, Vec<[u8; 3]>) -> Option<Panel>,
    shown: &impl Fn(&[Vector3<f32>]) -> Vec<[u8; 3]>,
) -> Result<Vec<Option<Panel>>, Failure> {
    let settings = Settings { source_side: args.order, ..Settings::default() };
    let mut relighter = Relighter::new(transport, settings)?;
    relighter.set_view(&scene.view)?;
    let mut radiance = vec![Vector3::zeros(); transport.vertices()];
    let start = &scene.lights_at(0.5)?[0];
    let [w, h] = start.size();
    let [width, _] = start.texture_size();
    let disc: Vec<f32> = (0..start.texture().len())
        .map(|i| {
            let height = start.texture().len() / width;
            let (u, v) = ((i % width) as f64 / width as f64 - 0.5, (i / width) as f64 / height as f64 - 0.5);
            f32::from(u8::from(u.hypot(v) < 0.4))
        })
        .collect();
    type Edit<'a> = (&'a str, &'a dyn Fn(&mut PlanarLight) -> Result<(), haarmonic::Error>);
    let edits: [Edit<'_>; 4] = [
        ("turned by 40°", &|light| light.set_rotation(0.7)),
        ("squeezed", &|light| light.set_size([2.0 * w, 0.25 * h])),
        ("masked by a disc", &|light| light.set_mask(&disc)),
        ("small and bright", &|light| {
            light.set_size([0.3 * w, 0.3 * h])?;
            let texture: Vec<_> = light.texture().iter().map(|t| t * 8.0).collect();
            light.set_texture(&texture)
        }),
    ];
    let mut row = Vec::new();
    for (what, edit) in edits {
        let mut light = start.clone();
        edit(&mut light)?;
        relighter.set_lights(&[light])?;
        relighter.relight(&mut radiance);
        row.push(panel(vec![format!("the lamp {what}")], shown(&radiance)));
    }
    Ok(row)
}

/// The lamp as it looks from below, x to the right.
pub fn lamp_picture(light: &PlanarLight, size: usize, tone: &ToneMap) -> Vec<[u8; 3]> {
    let [w, h] = light.extent();
    let side = size.next_power_of_two().min(256);
    let planes = light.pixels(side);
    let most = w.max(h);
    (0..size * size)
        .map(|i| {
            let place = |k: usize, extent: f64| ((k as f64 + 0.5) / size as f64 - 0.5) * most / extent + 0.5;
            let (u, v) = (place(i % size, w), place(i / size, h));
            if !(0.0..1.0).contains(&u) || !(0.0..1.0).contains(&v) {
                return [10, 10, 12];
            }
            let k = (v * side as f64) as usize * side + (u * side as f64) as usize;
            tone.apply(&Vector3::from(planes.each_ref().map(|p| p[k] * 0.15)))
        })
        .collect()
}

/// The 98th percentile of the radiance: what shall be white.
pub fn bright(truth: &[Vector3<f32>]) -> f64 {
    let mut values: Vec<f32> = truth.iter().map(|l| l.max()).collect();
    values.sort_by(f32::total_cmp);
    let bright = f64::from(values[(values.len() - 1) * 98 / 100]);
    if bright > 0.0 { bright } else { 1.0 }
}
