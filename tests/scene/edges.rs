//! Scenes, lights, views, BRDFs and the settings of back ends at the ends of their range: each case refuses, or gives
//! what is finite, or what its documentation says; no case panics.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use haarmonic::Error;
use haarmonic::backend::block_product::{self, BlockAngle, BlockLayout, Rule};
use haarmonic::backend::wavelet_double as double;
use haarmonic::backend::wavelet_triple::{self as triple, Slices};
use haarmonic::compress::ScanOrder;
use haarmonic::haar::{Keep, Weighting};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{
    AshikhminShirley, BinaryVisibility, BlinnPhong, Brdf, BrdfFn, BrdfSpec, Camera, Comparison, CookTorrance,
    DirectionTable, GroundTruth, Lambert, LocalFrame, Materials, Merl, Mesh, Phong, Procedural, Sum, TabulatedBrdf,
    TexelVisibility, ToneMap, View, VisibilityBaker, VisibilitySettings, Ward, percentile_peak, psnr_db,
};
use haarmonic::sphere::{CubeGrid, CubeMap};

/// What a case comes to.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Outcome {
    /// An error.
    Refused,
    /// Numbers that are all finite.
    Finite,
    /// At least one NaN among them.
    Nan,
    /// An infinity and no NaN among them.
    Infinite,
}

fn outcome(numbers: Result<Vec<f64>, Error>) -> Outcome {
    match numbers {
        Err(error) => {
            let text = error.to_string();
            // Says something, and nothing twice.
            assert!(text.len() > 12 && !text.contains("be not") && !text.contains("  "), "{text}");
            Outcome::Refused
        }
        Ok(numbers) if numbers.iter().any(|x| x.is_nan()) => Outcome::Nan,
        Ok(numbers) if numbers.iter().any(|x| x.is_infinite()) => Outcome::Infinite,
        Ok(_) => Outcome::Finite,
    }
}

const MAX: f64 = f64::MAX;
const TINY: f64 = 5e-324;

type Call = Box<dyn Fn(f64) -> Result<Vec<f64>, Error>>;

fn call(f: impl Fn(f64) -> Result<Vec<f64>, Error> + 'static) -> Call {
    Box::new(f)
}

/// Numbers that are tried, and what becomes of each.
struct Row {
    name: &'static str,
    call: Call,
    expected: [Outcome; 9],
}

const TRIED: [f64; 9] = [0.0, TINY, 1.0, -1.0, 1e30, MAX, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

fn albedo(make: impl Fn(f64) -> Result<f64, Error> + 'static) -> Call {
    call(move |x| make(x).map(|x| vec![x]))
}

/// f for directions from the zenith to the rim, both ways.
fn values(brdf: &dyn Brdf) -> Vec<f64> {
    let mut all = Vec::new();
    for wi in directions() {
        for wo in directions() {
            all.extend(brdf.eval(&wi, &wo).iter());
        }
    }
    all
}

fn directions() -> Vec<Vector3<f64>> {
    let mut all = vec![Vector3::z(), Vector3::x(), -Vector3::y(), -Vector3::z()];
    for z in [TINY, 1e-310, 1e-160, 1e-17, 1e-8, 0.3] {
        let flat = (1.0 - z * z).sqrt();
        all.extend([Vector3::new(flat, 0.0, z), Vector3::new(-flat, 0.0, z), Vector3::new(0.6 * flat, -0.8 * flat, z)]);
    }
    all
}

#[test]
fn every_constructor_and_call_has_the_outcome_that_it_documents() {
    use Outcome::{Finite as F, Infinite as I, Nan as N, Refused as R};
    let grey = Vector3::repeat;
    let brdf = |b: Result<Box<dyn Brdf>, Error>| b.map(|b| values(&*b));
    let single = |x: f64| x as f32;
    //   0, TINY, 1, −1, 1e30, MAX, NaN, ∞, −∞
    let unit = [F, F, F, R, R, R, R, R, R];
    let exponent = [F, F, F, R, R, R, R, R, R];
    let roughness = [R, R, F, R, R, R, R, R, R];
    let rows = vec![
        Row {
            name: "Lambert albedo",
            call: call(move |x| brdf(Lambert::new(grey(x)).map(|b| Box::new(b) as _))),
            expected: unit,
        },
        Row {
            name: "Phong albedo",
            call: call(move |x| brdf(Phong::new(grey(x), 5.0).map(|b| Box::new(b) as _))),
            expected: unit,
        },
        Row {
            name: "Phong exponent",
            call: call(move |x| brdf(Phong::new([0.5; 3], x).map(|b| Box::new(b) as _))),
            expected: exponent,
        },
        Row {
            name: "BlinnPhong exponent",
            call: call(move |x| brdf(BlinnPhong::new([0.5; 3], x).map(|b| Box::new(b) as _))),
            expected: exponent,
        },
        Row {
            name: "Ward albedo",
            call: call(move |x| brdf(Ward::new(grey(x), 0.3, 0.2).map(|b| Box::new(b) as _))),
            expected: unit,
        },
        Row {
            name: "Ward alpha_x",
            call: call(move |x| brdf(Ward::new([0.5; 3], x, 0.2).map(|b| Box::new(b) as _))),
            expected: roughness,
        },
        Row {
            name: "Ward alpha_y",
            call: call(move |x| brdf(Ward::new([0.5; 3], 1e-4, x).map(|b| Box::new(b) as _))),
            expected: roughness,
        },
        Row {
            name: "GGX F0",
            call: call(move |x| brdf(CookTorrance::new(grey(x), 0.3, 0.2).map(|b| Box::new(b) as _))),
            expected: unit,
        },
        Row {
            name: "GGX alpha",
            call: call(move |x| brdf(CookTorrance::isotropic([0.5; 3], x).map(|b| Box::new(b) as _))),
            expected: roughness,
        },
        Row {
            name: "GGX alpha_y",
            call: call(move |x| brdf(CookTorrance::new([0.5; 3], 1e-4, x).map(|b| Box::new(b) as _))),
            expected: roughness,
        },
        Row {
            name: "Ashikhmin diffuse",
            call: call(move |x| brdf(AshikhminShirley::new(grey(x), [0.5; 3], 9.0, 2.0).map(|b| Box::new(b) as _))),
            expected: unit,
        },
        Row {
            name: "Ashikhmin specular",
            call: call(move |x| brdf(AshikhminShirley::new([0.5; 3], grey(x), 9.0, 2.0).map(|b| Box::new(b) as _))),
            expected: unit,
        },
        Row {
            name: "Ashikhmin exponent_x",
            call: call(move |x| brdf(AshikhminShirley::new([0.5; 3], [0.5; 3], x, 1e7).map(|b| Box::new(b) as _))),
            expected: exponent,
        },
        Row {
            name: "Ashikhmin exponent_y",
            call: call(move |x| brdf(AshikhminShirley::new([0.5; 3], [0.5; 3], 0.0, x).map(|b| Box::new(b) as _))),
            expected: exponent,
        },
        Row {
            name: "weight of a sum",
            call: call(move |x| {
                let lambert: Arc<dyn Brdf> = Arc::new(Lambert::new([0.5; 3])?);
                Ok(values(&Sum::new(vec![(x, lambert)])?))
            }),
            expected: [F, F, F, R, F, F, R, R, R],
        },
        Row {
            name: "View eye",
            call: call(move |x| {
                Ok(View::eye(Vector3::new(single(x), 0.0, 1.0))?.wo(&Vector3::zeros()).as_slice().to_vec())
            }),
            expected: [F, F, F, F, F, R, R, R, R],
        },
        Row {
            name: "View towards",
            call: call(move |x| {
                Ok(View::towards(Vector3::new(0.0, single(x), 0.0))?.wo(&Vector3::zeros()).as_slice().to_vec())
            }),
            expected: [R, R, F, F, F, R, R, R, R],
        },
        Row {
            name: "camera eye",
            call: call(|x| camera(Camera::look_at(Vector3::new(x, 0.0, 2.0), Vector3::zeros(), Vector3::y(), 0.6))),
            expected: [F, F, F, F, F, F, R, R, R],
        },
        Row {
            name: "camera target beyond",
            call: call(|x| {
                camera(Camera::look_at(Vector3::new(-x, 0.5, 0.0), Vector3::new(x, 0.0, 0.0), Vector3::y(), 0.6))
            }),
            expected: [F, F, F, F, F, F, R, R, R],
        },
        Row {
            name: "camera at its target",
            call: call(|x| camera(Camera::look_at(Vector3::repeat(x), Vector3::repeat(x), Vector3::y(), 0.6))),
            expected: [R; 9],
        },
        Row {
            name: "camera up",
            call: call(|x| camera(Camera::look_at(Vector3::z(), Vector3::zeros(), Vector3::new(0.0, x, 0.0), 0.6))),
            expected: [F, F, F, F, F, F, R, R, R],
        },
        Row {
            name: "field of view",
            call: call(|x| camera(Camera::look_at(Vector3::z(), Vector3::zeros(), Vector3::y(), x))),
            expected: [R, F, F, R, R, R, R, R, R],
        },
        Row {
            name: "direction in a picture",
            call: call(|x| Ok(standard()?.direction(x, 0.0).as_slice().to_vec())),
            expected: [F, F, F, F, F, F, N, N, N],
        },
        Row {
            name: "exposure",
            call: albedo(move |x| Ok(f64::from(ToneMap::with_exposure(single(x)).exposure()))),
            expected: [F, F, F, F, F, I, F, I, F],
        },
        Row { name: "white", call: albedo(|x| Ok(f64::from(ToneMap::with_white(x).exposure()))), expected: [F; 9] },
        Row {
            name: "tone map",
            call: call(move |x| Ok(ToneMap::default().apply(&Vector3::repeat(single(x))).map(f64::from).to_vec())),
            expected: [F; 9],
        },
        Row {
            name: "peak",
            call: albedo(|x| percentile_peak(&[Vector3::repeat(x)])),
            expected: [F, F, F, F, F, F, R, R, R],
        },
        Row {
            name: "PSNR peak",
            call: albedo(|x| psnr_db(&[Vector3::repeat(1.0)], &[Vector3::repeat(1.5)], x)),
            expected: [I, F, F, R, F, F, R, R, R],
        },
        Row {
            name: "comparison",
            call: call(|x| {
                let c = Comparison::new(&[Vector3::repeat(x)], &[Vector3::repeat(0.5 * x)])?;
                Ok(vec![c.psnr_db, c.rel_l2, c.max_abs])
            }),
            // Equal lists have a PSNR of +∞: 0 is half of 0, and of the smallest number half is 0.
            expected: [I, F, F, I, F, F, R, R, R],
        },
        Row {
            name: "comparison with the opposite",
            call: call(|x| {
                let c = Comparison::new(&[Vector3::repeat(x.abs())], &[Vector3::repeat(-x.abs())])?;
                Ok(vec![c.psnr_db, c.rel_l2])
            }),
            expected: [I, F, F, F, F, F, R, R, R],
        },
        Row {
            name: "tolerance of block products",
            call: albedo(|x| Rule::bounded(x).map(|_| x)),
            expected: [F, F, F, R, F, F, R, R, R],
        },
        Row {
            name: "tolerance of the transport",
            call: call(move |x| bake(Lambert::new([0.5; 3])?, single(x))),
            expected: [F, F, R, R, R, R, R, R, R],
        },
        Row {
            name: "light of ground truth",
            call: call(move |x| Stage::new(Lambert::new([0.5; 3])?).truth(single(x))),
            expected: [F, F, F, F, F, R, R, R, R],
        },
    ];
    for Row { name, call, expected } in rows {
        for (x, expected) in TRIED.into_iter().zip(expected) {
            let got = catch_unwind(AssertUnwindSafe(|| outcome(call(x))));
            assert!(matches!(got, Ok(got) if got == expected), "{name} of {x:e}: {got:?}, not {expected:?}");
        }
    }
}

fn standard() -> Result<Camera, Error> {
    Camera::look_at(Vector3::new(0.0, 1.0, 3.0), Vector3::zeros(), Vector3::y(), 0.6)
}

fn camera(camera: Result<Camera, Error>) -> Result<Vec<f64>, Error> {
    let camera = camera?;
    Ok([camera.eye(), *camera.forward(), *camera.direction(0.5, -0.3)].iter().flat_map(|v| v.iter().copied()).collect())
}

#[test]
fn sizes_beyond_all_bounds_are_refused() {
    let grid = CubeGrid::new(8).unwrap();
    for n in [usize::MAX, usize::MAX / 2, 1 << 40, 0] {
        let refused = [
            CubeGrid::new(n).map(drop),
            Procedural::Table.build(n).map(drop),
            TabulatedBrdf::new(&Lambert::new([0.5; 3]).unwrap(), n).map(drop),
            BlockLayout::new(grid, n, ScanOrder::Hilbert).map(drop),
        ];
        assert!(refused.iter().all(Result::is_err), "{n}: {refused:?}");
    }
    let stage = Stage::new(Lambert::new([0.5; 3]).unwrap());
    let transport = triple::Transport::from_binary(stage.visibility.clone()).unwrap();
    for side in [0, usize::MAX, 1 << 40] {
        let settings = triple::Settings { slices: Slices::Tabulated(side), ..triple::Settings::default() };
        assert!(triple::Relighter::new(&stage.mesh, &transport, settings).is_err(), "{side}");
    }
}

/// A tilted square, two triangles.
fn square() -> Mesh {
    let corner = |x: f32, z: f32| Vector3::new(x, 0.3 * x + 0.1 * z, z);
    let positions = vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
    Mesh::new(positions, vec![[0, 1, 2], [0, 2, 3]]).unwrap()
}

/// One mesh under one light.
struct Stage {
    mesh: Mesh,
    visibility: BinaryVisibility,
    materials: Materials,
    view: View,
    grid: CubeGrid,
}

impl Stage {
    fn new(brdf: impl Brdf + 'static) -> Self {
        let lambert: Arc<dyn Brdf> = Arc::new(Lambert::new([0.5; 3]).unwrap());
        Self::of(vec![lambert, Arc::new(brdf)])
    }

    /// Vertices 0 and 1 have the first material, 2 and 3 the second.
    fn of(brdfs: Vec<Arc<dyn Brdf>>) -> Self {
        let (mesh, grid) = (square(), CubeGrid::new(16).unwrap());
        let visibility = VisibilityBaker::new(&mesh, grid, VisibilitySettings::default()).unwrap().bake(&()).unwrap();
        let materials = Materials::new(brdfs, vec![0, 0, 1, 1]).unwrap();
        Self { mesh, visibility, materials, view: View::eye(Vector3::new(0.5, 4.0, 1.0)).unwrap(), grid }
    }

    fn light(&self, radiance: f32) -> CubeMap<Vector3<f32>> {
        CubeMap::from_fn(self.grid, |d| Vector3::repeat(radiance * (1.0 + 0.5 * d.x as f32)))
    }

    fn truth(&self, radiance: f32) -> Result<Vec<f64>, Error> {
        let light = self.light(radiance);
        let truth = GroundTruth { mesh: &self.mesh, materials: &self.materials, view: &self.view, light: &light };
        Ok(flat(truth.radiance(&TexelVisibility::Binary(&self.visibility), &())?))
    }

    fn double(&self, light: &CubeMap<Vector3<f32>>, settings: double::BakeSettings) -> Result<Vec<f64>, Error> {
        let transport =
            double::Transport::bake(&self.mesh, &self.visibility, &self.view, &self.materials, settings, &())?;
        let settings = double::Settings { light_terms: Keep::Fraction(1.0), weighting: Weighting::Area };
        let mut relighter = double::Relighter::new(&transport, settings)?;
        relighter.set_light(light)?;
        let mut out = vec![Vector3::zeros(); 4];
        relighter.relight(&self.view, &self.materials, &mut out)?;
        Ok(flat(out))
    }

    fn triple(&self, light: &CubeMap<Vector3<f32>>, slices: Slices, keep: Keep) -> Result<Vec<f64>, Error> {
        let transport = triple::Transport::from_binary(self.visibility.clone())?;
        let settings = triple::Settings { light_terms: keep, brdf_terms: keep, weighting: Weighting::Area, slices };
        let mut relighter = triple::Relighter::new(&self.mesh, &transport, settings)?;
        relighter.set_light(light)?;
        let mut out = vec![Vector3::zeros(); 4];
        relighter.relight(&self.view, &self.materials, &mut out)?;
        Ok(flat(out))
    }

    fn blocks(&self, light: &CubeMap<Vector3<f32>>, rule: Rule) -> Result<Vec<f64>, Error> {
        let layout = BlockLayout::new(self.grid, 16, ScanOrder::Hilbert)?;
        let transport = block_product::Transport::from_binary(&self.mesh, &self.visibility, &layout)?;
        let settings = block_product::Settings { rule, ..block_product::Settings::default() };
        let mut relighter = block_product::Relighter::new(&self.mesh, &transport, settings)?;
        relighter.set_light(light)?;
        let mut out = vec![Vector3::zeros(); 4];
        relighter.relight(&self.view, &self.materials, &mut out)?;
        Ok(flat(out))
    }

    /// Every way to light it, by name.
    fn all(&self, light: &CubeMap<Vector3<f32>>) -> Vec<(&'static str, Result<Vec<f64>, Error>)> {
        let few = Keep::Fraction(0.1);
        let truth = GroundTruth { mesh: &self.mesh, materials: &self.materials, view: &self.view, light };
        vec![
            ("ground truth", truth.radiance(&TexelVisibility::Binary(&self.visibility), &()).map(flat)),
            ("double", self.double(light, double::BakeSettings::default())),
            ("triple, all terms", self.triple(light, Slices::Sampled, Keep::Fraction(1.0))),
            ("triple, few terms", self.triple(light, Slices::Sampled, few)),
            ("triple, tabulated", self.triple(light, Slices::Tabulated(8), few)),
            ("blocks, bounded", self.blocks(light, Rule::default())),
            ("blocks, fixed", self.blocks(light, Rule::Fixed { angle: BlockAngle::Nearest })),
            ("blocks, pixels", self.blocks(light, Rule::Pixels)),
        ]
    }
}

fn flat<T: haarmonic::Real>(radiance: Vec<Vector3<T>>) -> Vec<f64> {
    radiance.iter().flat_map(|r| r.iter().map(|c| c.widen())).collect()
}

fn bake(brdf: impl Brdf + 'static, tolerance: f32) -> Result<Vec<f64>, Error> {
    let stage = Stage::new(brdf);
    stage.double(&stage.light(1.0), double::BakeSettings { tolerance, ..double::BakeSettings::default() })
}

#[test]
fn a_brdf_of_nan_is_named_by_every_way_to_light() {
    type Value = fn(&Vector3<f64>, &Vector3<f64>) -> f64;
    let closures: [(&str, Value); 5] = [
        ("everywhere", |_, _| f64::NAN),
        ("towards grazing light", |wi, _| if wi.z < 0.4 { f64::NAN } else { 0.2 }),
        ("near the zenith", |wi, _| if wi.z > 0.9 { f64::NAN } else { 0.2 }),
        ("infinite on one side", |wi, _| if wi.x > 0.1 { f64::INFINITY } else { 0.2 }),
        ("0/0 off the mirror", |wi, wo| {
            let off = (wi.x + wo.x).hypot(wi.y + wo.y) - 0.5;
            0.2 * (off.max(0.0) / off.max(0.0))
        }),
    ];
    for (name, value) in closures {
        let brdfs: [Arc<dyn Brdf>; 3] = [
            Arc::new(BrdfFn::grey(value)),
            Arc::new(BrdfFn::new(move |wi: &Vector3<f64>, wo: &Vector3<f64>| Vector3::new(0.1, value(wi, wo), 0.3))),
            Arc::new(
                Sum::new(vec![
                    (0.5, Arc::new(Lambert::new([0.5; 3]).unwrap()) as Arc<dyn Brdf>),
                    (0.5, Arc::new(BrdfFn::grey(value))),
                ])
                .unwrap(),
            ),
        ];
        for brdf in brdfs {
            let stage = Stage::of(vec![Arc::new(Phong::new([0.5; 3], 20.0).unwrap()), brdf]);
            for (way, result) in stage.all(&stage.light(1.0)) {
                let error = result.expect_err(&format!("{name}, {way}"));
                assert_eq!(error, Error::NotFinite { what: "value of BRDF", index: 1 }, "{name}, {way}");
            }
        }
    }
    // The same ways light what is well.
    let stage = Stage::new(BrdfFn::grey(|_, _| 0.2));
    let truth = stage.truth(1.0).unwrap();
    for (way, result) in stage.all(&stage.light(1.0)) {
        let result = result.unwrap();
        let off = result.iter().zip(&truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // One block a face: the fixed rule takes few samples of it.
        assert!(off < 0.2, "{way}: {result:?} {truth:?}");
    }
}

#[test]
fn a_light_on_another_grid_is_the_same_error_everywhere() {
    let stage = Stage::new(Lambert::new([0.5; 3]).unwrap());
    let light = CubeMap::from_fn(CubeGrid::new(8).unwrap(), |_| Vector3::repeat(1.0f32));
    let truth = GroundTruth { mesh: &stage.mesh, materials: &stage.materials, view: &stage.view, light: &light };
    let mut ways = stage.all(&light);
    ways[0].1 = truth.radiance(&TexelVisibility::Binary(&stage.visibility), &()).map(flat);
    for (way, result) in ways {
        let expected = Error::Length { what: "side of the light's cube map", expected: 16, got: 8 };
        assert_eq!(result, Err(expected), "{way}");
    }
}

/// Every kind of BRDF.
fn brdfs() -> Vec<(&'static str, Arc<dyn Brdf>)> {
    let ward = Ward::new([0.5, 0.4, 0.3], 0.2, 0.4).unwrap();
    let merl = Merl::from_bytes(&Merl::bytes_from(&Phong::new([0.5; 3], 10.0).unwrap())).unwrap();
    let terms: Vec<(f64, Arc<dyn Brdf>)> =
        vec![(0.5, Arc::new(ward)), (0.0, Arc::new(Lambert::new([0.5; 3]).unwrap()))];
    vec![
        ("Lambert", Arc::new(Lambert::new([0.5, 0.4, 0.3]).unwrap())),
        ("black", Arc::new(Lambert::new([0.0; 3]).unwrap())),
        ("Phong", Arc::new(Phong::new([0.5, 0.4, 0.3], 20.0).unwrap())),
        ("Phong of 0", Arc::new(Phong::new([0.5; 3], 0.0).unwrap())),
        ("Blinn–Phong", Arc::new(BlinnPhong::new([0.5, 0.4, 0.3], 20.0).unwrap())),
        ("Ward", Arc::new(ward)),
        ("GGX", Arc::new(CookTorrance::new([0.5, 0.4, 0.3], 0.2, 0.4).unwrap())),
        ("grey GGX", Arc::new(CookTorrance::isotropic([0.5; 3], 0.2).unwrap())),
        ("Ashikhmin–Shirley", Arc::new(AshikhminShirley::new([0.5; 3], [0.4; 3], 20.0, 50.0).unwrap())),
        ("table", Arc::new(TabulatedBrdf::new(&Phong::new([0.5; 3], 3.0).unwrap(), 6).unwrap())),
        ("anisotropic table", Arc::new(TabulatedBrdf::new(&ward, 3).unwrap())),
        ("MERL", Arc::new(merl.clone())),
        ("MERL, nearest", Arc::new(merl.with_lookup(haarmonic::scene::MerlLookup::Nearest))),
        ("sum", Arc::new(Sum::new(terms).unwrap())),
        ("closure", Arc::new(BrdfFn::grey(|_, _| 0.2))),
        ("closure of RGB", Arc::new(BrdfFn::new(|_, _| Vector3::new(0.1, 0.2, 0.3)))),
        ("spec", "phong:50+lambert:0.4".parse::<BrdfSpec>().unwrap().build().unwrap()),
    ]
}

#[test]
fn a_direction_that_is_nan_gives_nan_by_every_brdf() {
    let (wi, wo) = (Vector3::new(0.0, 0.6, 0.8), Vector3::new(0.48, -0.36, 0.8));
    let frame = LocalFrame { tangent: Vector3::x(), bitangent: Vector3::y(), normal: Vector3::z() };
    let table = DirectionTable::new(CubeGrid::new(5).unwrap());
    for (name, brdf) in brdfs() {
        assert!(brdf.eval(&wi, &wo).iter().all(|c| c.is_finite()), "{name}");
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for k in 0..3 {
                let spoilt = |mut d: Vector3<f64>| {
                    d[k] = bad;
                    d
                };
                for (wi, wo) in [(spoilt(wi), wo), (wi, spoilt(wo)), (spoilt(wi), spoilt(wo)), (spoilt(-wi), wo)] {
                    assert!(brdf.eval(&wi, &wo).iter().all(|c| c.is_nan()), "{name}: {wi:?} {wo:?}");
                }
                let mut out = vec![0.0; brdf.planes() * table.len()];
                brdf.sample_cos(&frame, &spoilt(wo), &table, &mut out);
                assert!(out.iter().all(|x| x.is_nan()), "{name}: viewer {k}");
                let mut turned = frame;
                turned.normal[k] = bad as f32;
                brdf.sample_cos(&turned, &wo, &table, &mut out);
                assert!(out.iter().all(|x| x.is_nan()), "{name}: normal {k}");
            }
        }
        // At and below the horizon there is nothing, beside it something finite.
        for wi in directions() {
            for wo in directions() {
                let f = brdf.eval(&wi, &wo);
                assert!(f.iter().all(|c| c.is_finite() && *c >= 0.0), "{name}: {wi:?} {wo:?} {f:?}");
                assert!((wi.z > 0.0 && wo.z > 0.0) || f == Vector3::zeros(), "{name}: {wi:?} {wo:?} {f:?}");
            }
        }
    }
}

#[test]
fn sums_within_sums_have_an_end() {
    let lambert: Arc<dyn Brdf> = Arc::new(Lambert::new([0.5; 3]).unwrap());
    // A chain.
    let mut deep = lambert.clone();
    let mut depth = 0;
    while let Ok(sum) = Sum::new(vec![(1.0, deep.clone())]) {
        deep = Arc::new(sum);
        depth += 1;
    }
    assert_eq!(depth, 64);
    assert_eq!(deep.eval(&Vector3::z(), &Vector3::z()), lambert.eval(&Vector3::z(), &Vector3::z()));
    // A tree that doubles.
    let mut wide = lambert.clone();
    let mut doublings = 0;
    while let Ok(sum) = Sum::new(vec![(0.5, wide.clone()), (0.5, wide.clone())]) {
        wide = Arc::new(sum);
        doublings += 1;
    }
    assert_eq!(doublings, 11);
    assert!(Sum::new(vec![(1.0, lambert); 4097]).is_err());
}
