//! The right answers: of the lamps themselves, of the cells of the face, and of lamps that are taken for distant.

use haarmonic::affine::{Propagation, PropagationRoute, PropagationScratch, PropagationSource, Targets};
use haarmonic::backend::near_field::{BakeSettings, PlanarLight};
use haarmonic::haar::{Decomposition, Transform2d};
use haarmonic::nalgebra::{Rotation2, Vector3};
use haarmonic::scene::{
    Directions, GroundTruth, LocalTruth, TexelVisibility, Viewpoint, VisibilityBaker, VisibilitySettings,
    VisibilityTracer,
};
use haarmonic::sphere::{CubeGrid, CubeMap, TopFace};
use rayon::prelude::*;

use crate::scene::{Scene, local};
use crate::support::Failure;
use crate::support::progress::Bar;

/// The radiance of every vertex under the lamps themselves, over the whole hemisphere.
pub fn of_lamps(scene: &Scene, lights: &[PlanarLight], samples: usize) -> Result<Vec<Vector3<f64>>, Failure> {
    let lights = local(lights)?;
    let bar = Bar::new("ground truth");
    let truth = LocalTruth {
        mesh: &scene.mesh,
        materials: &scene.materials,
        view: &scene.view,
        lights: &lights,
        occluders: Some(&scene.occluders),
        fog: None,
    };
    let radiance = truth.radiance(samples, &bar)?;
    bar.finish();
    Ok(radiance)
}

/// The same sum over the cells of the face in `f64`, with everything kept: what the method computes, by other code.
pub fn of_cells(
    scene: &Scene,
    lights: &[PlanarLight],
    bake: &BakeSettings,
    side: usize,
) -> Result<Vec<Vector3<f64>>, Failure> {
    let (face, fine) =
        (TopFace::new(bake.face_size, bake.cells)?, TopFace::new(bake.face_size, bake.cells * bake.samples)?);
    let (cells, frame) = (face.cells(), bake.frame);
    let tracer = VisibilityTracer::new(scene.occluders.clone(), Directions::top_face(fine));
    let viewpoints = Viewpoint::of_vertices(&scene.mesh, bake.offset)?;
    let plan = Propagation::<f64>::between(side, cells, Decomposition::Standard)?;
    let transform = Transform2d::<f64>::new(cells, cells, Decomposition::Standard)?;
    let all = Targets::all(cells, Decomposition::Standard)?;
    let sources = lights
        .iter()
        .map(|light| {
            let planes = light.pixels(side).map(|plane| plane.into_iter().map(f64::from).collect::<Vec<_>>());
            PropagationSource::<f64, 3>::from_pixels(
                side,
                Decomposition::Standard,
                planes.each_ref().map(Vec::as_slice),
            )
        })
        .collect::<Result<Vec<_>, _>>()?;
    let directions: Vec<Vector3<f64>> =
        (0..fine.len()).map(|i| frame.to_world(&fine.cell_direction(i)).normalize()).collect();
    let omega: Vec<f64> = (0..fine.len()).map(|i| fine.solid_angle(i % fine.cells(), i / fine.cells())).collect();
    let vertex = |vertex: usize| -> Result<Vector3<f64>, haarmonic::Error> {
        let mut words = vec![0; tracer.directions().words()];
        tracer.trace(&viewpoints[vertex].with_frame(frame)?, &mut words, &mut tracer.scratch());
        let (surface, brdf) = (scene.mesh.local_frame(vertex), scene.materials.brdf(vertex));
        let wo = surface.to_local(&scene.view.outgoing(brdf, &scene.mesh.positions()[vertex], &surface));
        let mut transport = vec![Vector3::zeros(); face.len()];
        for (ray, direction) in directions.iter().enumerate().filter(|(ray, _)| words[ray / 64] >> (ray % 64) & 1 == 1)
        {
            let wi = surface.to_local(direction);
            let (x, y) = (ray % fine.cells() / bake.samples, ray / fine.cells() / bake.samples);
            transport[y * cells + x] += brdf.eval(&wi, &wo) * (wi.z.max(0.0) * omega[ray]);
        }
        let position = scene.mesh.positions()[vertex].cast();
        let (mut planes, mut scratch) = (vec![0.0; 3 * face.len()], PropagationScratch::new());
        let (mut pixels, mut work) = (vec![0.0; face.len()], vec![0.0; transform.scratch_len()]);
        let mut sum = Vector3::zeros();
        for (light, source) in lights.iter().zip(&sources) {
            let Some(maps) = light.maps(&face, &frame, &position) else { continue };
            let [r, g, b] = planes
                .get_disjoint_mut([0..face.len(), face.len()..2 * face.len(), 2 * face.len()..3 * face.len()])
                .expect("three planes");
            plan.apply_by(PropagationRoute::Pixels, source, maps, &all, [r, g, b], &mut scratch);
            for (c, plane) in planes.chunks_exact(face.len()).enumerate() {
                transform.inverse(plane, &mut pixels, &mut work);
                sum[c] += pixels.iter().zip(&transport).map(|(l, t)| l * t[c]).sum::<f64>();
            }
        }
        Ok(sum)
    };
    Ok((0..scene.mesh.positions().len()).into_par_iter().map(vertex).collect::<Result<_, _>>()?)
}

/// Lamps taken for an environment: what arrives at the middle of the scene arrives everywhere.
pub fn as_if_distant(scene: &Scene, lights: &[PlanarLight]) -> Result<Vec<Vector3<f64>>, Failure> {
    const FINE: usize = 4;
    let grid = CubeGrid::new(32)?;
    let frame = BakeSettings::default().frame;
    let middle = scene.mesh.bounds().centre();
    let seen = |direction: &Vector3<f64>| -> Vector3<f64> {
        let local = frame.to_local(direction);
        if local.z <= 0.0 {
            return Vector3::zeros();
        }
        let one = |light: &PlanarLight| {
            let to = frame.to_local(&(light.centre() - middle));
            let at = (local * (to.z / local.z) - to).xy();
            let at = Rotation2::new(-light.rotation()) * at;
            let [width, height] = light.texture_size();
            let place = |x: f64, size: f64, n: usize| ((x / size + 0.5) * n as f64).floor();
            let (x, y) = (place(at.x, light.size()[0], width), place(at.y, light.size()[1], height));
            let inside = (0.0..width as f64).contains(&x) && (0.0..height as f64).contains(&y) && to.z > 0.0;
            if inside { light.radiance(y as usize * width + x as usize).cast() } else { Vector3::zeros() }
        };
        lights.iter().map(one).sum()
    };
    // Texels of a finer map, averaged.
    let fine = CubeMap::from_fn(CubeGrid::new(grid.side() * FINE)?, |d| seen(&d));
    let side = grid.side() * FINE;
    let texel = |i: usize| -> Vector3<f32> {
        let (face, y, x) = (i / grid.face_len(), i % grid.face_len() / grid.side(), i % grid.side());
        let one = |k: usize| fine.texels()[(face * side + FINE * y + k / FINE) * side + FINE * x + k % FINE];
        ((0..FINE * FINE).map(one).sum::<Vector3<f64>>() / (FINE * FINE) as f64).cast()
    };
    let light = CubeMap::new(grid, (0..grid.len()).map(texel).collect())?;
    let visibility = VisibilityBaker::new(&scene.mesh, grid, VisibilitySettings::default())?.bake(&())?;
    let truth = GroundTruth { mesh: &scene.mesh, materials: &scene.materials, view: &scene.view, light: &light };
    Ok(truth.radiance(&TexelVisibility::Binary(&visibility), &())?)
}
