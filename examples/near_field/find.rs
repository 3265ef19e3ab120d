//! A lamp found from one picture: the error of the picture falls along its gradient in the lamp.

use haarmonic::backend::near_field::{PlanarLight, Relighter, Settings};
use haarmonic::nalgebra::{SMatrix, SVector, Vector3};
use haarmonic::scene::{Bvh, Mesh, Picture, ToneMap};
use serde_json::json;

use crate::args::Args;
use crate::frames::{bake, bake_settings, bright, lamp_picture};
use crate::scene::Scene;
use crate::support::axis::{Axis, Scale};
use crate::support::plot::{Chart, Series};
use crate::support::sheet::{Panel, Sheet};
use crate::support::timer::seconds;
use crate::support::{self, Failure, table};
use crate::truth;

/// Place in radii of the scene, logarithms of the sizes, angle.
type Point = SVector<f64, 6>;

/// Steps at most, and what the error must fall by in one to go on.
const STEPS: usize = 80;
const FALL: f64 = 1e-5;

/// The error of a picture as a function of the lamp.
struct Loss<'a, 'b> {
    scene: &'a Scene,
    relighter: Relighter<'b>,
    /// Of each pixel: what it shows.
    pixels: Vec<Option<([u32; 3], [f32; 3])>>,
    target: Vec<Vector3<f32>>,
    energy: f64,
    radiance: Vec<Vector3<f32>>,
    evaluations: usize,
}

impl Loss<'_, '_> {
    fn light(&self, point: &Point) -> Result<PlanarLight, Failure> {
        let mut light = self.scene.lights[0].clone();
        light.set_centre(Vector3::new(point[0], point[1], point[2]) * self.scene.radius)?;
        light.set_size([point[3].exp(), point[4].exp()])?;
        light.set_rotation(point[5])?;
        Ok(light)
    }

    /// Σ |pixel − target|²/Σ |target|², and its gradient.
    fn at(&mut self, point: &Point) -> Result<(f64, Point), Failure> {
        self.evaluations += 1;
        let light = self.light(point)?;
        self.relighter.set_lights(std::slice::from_ref(&light))?;
        self.relighter.relight(&mut self.radiance);
        let mut slopes = vec![Vector3::<f32>::zeros(); self.radiance.len()];
        let mut loss = 0.0;
        for (pixel, target) in self.pixels.iter().zip(&self.target) {
            let Some((corners, weights)) = pixel else { continue };
            let shown: Vector3<f32> = (0..3).map(|k| self.radiance[corners[k] as usize] * weights[k]).sum();
            let off = shown - target;
            loss += f64::from(off.norm_squared());
            for k in 0..3 {
                slopes[corners[k] as usize] += off * (2.0 * weights[k] / self.energy as f32);
            }
        }
        let gradient = self.relighter.gradient(0, &light, &slopes)?;
        let [w, h] = light.size();
        let along = gradient.centre * self.scene.radius;
        let gradient = [along.x, along.y, along.z, gradient.size[0] * w, gradient.size[1] * h, gradient.rotation];
        Ok((loss / self.energy, gradient.into()))
    }
}

pub fn run(args: &Args, scene: &Scene) -> Result<(), Failure> {
    let (transport, bake_s) = bake(args, scene, bake_settings(args))?;
    let hidden = scene.lights[0].clone();
    let truth: Vec<Vector3<f32>> =
        truth::of_lamps(scene, std::slice::from_ref(&hidden), args.truth_samples)?.iter().map(|l| l.cast()).collect();
    let bvh = Bvh::new(&scene.mesh);
    let (one_ray, shown) = (
        Picture::new(&scene.mesh, &bvh, &scene.camera, [args.size; 2], 1)?,
        Picture::new(&scene.mesh, &bvh, &scene.camera, [args.size; 2], 3)?,
    );
    let target = one_ray.shade(&truth, |_| Vector3::zeros());
    let settings = Settings { source_side: args.order, ..Settings::default() };
    let mut relighter = Relighter::new(&transport, settings)?;
    relighter.set_view(&scene.view)?;
    let mut loss = Loss {
        scene,
        relighter,
        pixels: what_shows(&one_ray, &scene.mesh, args.size),
        energy: target.iter().map(|t| f64::from(t.norm_squared())).sum(),
        target,
        radiance: vec![Vector3::zeros(); truth.len()],
        evaluations: 0,
    };
    let place = |light: &PlanarLight| -> Point {
        let centre = light.centre() / scene.radius;
        let [w, h] = light.size();
        [centre.x, centre.y, centre.z, w.ln(), h.ln(), light.rotation()].into()
    };
    // Half a radius off, higher, twice as wide and half as high, turned.
    let wanted = place(&hidden);
    let start = wanted + Point::from([0.5, 0.4, -0.4, 0.6, -0.6, 0.4]);
    let (found, took) = seconds(|| descend(&mut loss, start));
    let (found, losses) = found?;
    let light = loss.light(&found)?;
    let size = scene.mesh.bounds().size().norm();
    let off = (light.centre() - hidden.centre()).norm() / size;
    let sizes = [0, 1].map(|k| (light.size()[k] - hidden.size()[k]).abs() / size);
    let row = |name: &str, light: &PlanarLight| {
        let (c, [w, h]) = (light.centre(), light.size());
        vec![
            name.to_owned(),
            format!("{:.4}, {:.4}, {:.4}", c.x, c.y, c.z),
            format!("{w:.4} × {h:.4}"),
            format!("{:.2}°", light.rotation().to_degrees()),
        ]
    };
    let rows = [row("start", &loss.light(&start)?), row("found", &light), row("hidden", &hidden)];
    println!("{}", table::format(&["lamp", "centre", "size", "angle"], &rows));
    println!(
        "{} steps, {} gradients, {took:.2} s; error of the picture {:.2e} → {:.2e}; place off by {:.3} % of the scene, sizes by {:.3} and {:.3} %",
        losses.len() - 1,
        loss.evaluations,
        losses[0],
        losses[losses.len() - 1],
        100.0 * off,
        100.0 * sizes[0],
        100.0 * sizes[1]
    );
    let tone = ToneMap::with_white(bright(&truth));
    let mut panels = vec![];
    for (name, point) in [("start", start), ("found", found)] {
        let lamp = loss.light(&point)?;
        loss.at(&point)?;
        let pixels = shown.shade(&loss.radiance, |_| Vector3::repeat(0.03)).iter().map(|l| tone.apply(l)).collect();
        panels.push((vec![name.to_owned()], pixels, lamp_picture(&lamp, args.size, &tone)));
    }
    let pixels = shown.shade(&truth, |_| Vector3::repeat(0.03)).iter().map(|l| tone.apply(l)).collect();
    panels.push((
        vec!["the picture that was given:".to_owned(), "ground truth of the hidden lamp".to_owned()],
        pixels,
        lamp_picture(&hidden, args.size, &tone),
    ));
    let panel = |caption: Vec<String>, pixels| Some(Panel { caption, width: args.size, height: args.size, pixels });
    let (mut first, mut second) = (vec![], vec![]);
    for (caption, picture, lamp) in panels {
        first.push(panel(caption, picture));
        second.push(panel(vec!["its lamp".to_owned()], lamp));
    }
    args.folder.save(
        "near_field_find.png",
        &Sheet::new("A lamp found from one picture by gradient descent", &[first, second]),
    )?;
    let points = losses.iter().enumerate().map(|(k, &l)| [k as f64, l]).collect();
    let chart = Chart {
        title: "Error of the picture while the lamp is found".to_owned(),
        x: Axis::new("step", Scale::Linear),
        y: Axis::new("relative squared error", Scale::Log10),
        series: vec![Series::new("", 0, points)],
        size: [900, 520],
    };
    args.folder.save("near_field_loss.png", &chart.draw())?;
    println!("pictures: near_field_find.png, near_field_loss.png in {}", args.folder.path.display());
    let results = json!([{
        "method": "bfgs", "vertices": truth.len(), "steps": losses.len() - 1, "gradients": loss.evaluations, "seconds": took,
        "loss": losses, "position_error": off, "size_errors": sizes, "bake_s": bake_s,
        "threads": rayon::current_num_threads(),
    }]);
    support::write_report(&args.common, "near_field", json!({ "mesh": scene.name, "find": true }), results)
}

/// The corners and weights of what each pixel's ray meets.
fn what_shows(picture: &Picture, mesh: &Mesh, size: usize) -> Vec<Option<([u32; 3], [f32; 3])>> {
    let hit = |i: usize| picture.sample([i % size, i / size], 0).hit;
    (0..size * size).map(|i| hit(i).map(|hit| (mesh.faces()[hit.face as usize], hit.barycentric))).collect()
}

/// The method of Broyden, Fletcher, Goldfarb and Shanno, with steps that are halved until the error falls.
fn descend(loss: &mut Loss<'_, '_>, start: Point) -> Result<(Point, Vec<f64>), Failure> {
    let mut inverse = SMatrix::<f64, 6, 6>::identity();
    let mut point = start;
    let (mut value, mut gradient) = loss.at(&point)?;
    let mut losses = vec![value];
    // The first step: a twentieth of a radius at most.
    inverse *= 0.05 / gradient.norm().max(1e-30);
    for _ in 0..STEPS {
        let mut step = -inverse * gradient;
        if step.dot(&gradient) >= 0.0 {
            inverse = SMatrix::identity() * (0.05 / gradient.norm());
            step = -inverse * gradient;
        }
        // No further than where the picture is still like it is.
        step *= (0.3 / step.amax()).min(1.0);
        let slope = step.dot(&gradient);
        let mut next = None;
        for _ in 0..12 {
            let trial = point + step;
            let (v, g) = loss.at(&trial)?;
            if v < value + 1e-4 * slope {
                next = Some((trial, v, g));
                break;
            }
            step *= 0.4;
        }
        let Some((trial, v, g)) = next else { break };
        let (s, y) = (trial - point, g - gradient);
        let sy = s.dot(&y);
        if sy > 1e-12 * s.norm() * y.norm() {
            if losses.len() == 1 {
                inverse = SMatrix::identity() * (sy / y.norm_squared());
            }
            let left = SMatrix::<f64, 6, 6>::identity() - s * y.transpose() / sy;
            inverse = left * inverse * left.transpose() + s * s.transpose() / sy;
        }
        let fall = 1.0 - v / value;
        (point, value, gradient) = (trial, v, g);
        losses.push(value);
        if fall < FALL {
            break;
        }
    }
    Ok((point, losses))
}
