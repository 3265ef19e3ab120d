//! Writes the inputs that fuzzing starts from:
//! `cargo test --all-features --test fuzz -- --ignored write_the_seeds`.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use exr::prelude::{Blocks, SampleType, Vec2};
use haarmonic::backend::{block_product, near_field, wavelet_double, wavelet_triple};
use haarmonic::compress::{
    BiclusterSettings, Biclustering, ByteBlocks, ClusteredPca, ClusteredPcaSettings, CodedBinaryMaps, CodedGrayMaps,
    Pca, PcaSettings, QuantisedBytes, QuantisedHalf, ScanOrder, SparseMatrix,
};
use haarmonic::io::{Image, encode_exr, encode_hdr, encode_ply, encode_png_srgb8};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{
    BinaryVisibility, Brdf, Lambert, Materials, Mesh, Occluders, Phong, View, VisibilityBaker, VisibilitySettings,
};
use haarmonic::sphere::CubeGrid;
use haarmonic::store::Stored;
use miniz_oxide::deflate::compress_to_vec_zlib;

use super::corpus;
use super::exr_files::{COMPRESSIONS, file as exr_file};
use super::noise::Stream;

/// Longer inputs make a fuzzer slow.
const LONGEST: usize = 4096;

/// Puts inputs, each behind its byte of settings, into the corpus of a target.
fn write(target: &str, inputs: impl IntoIterator<Item = (String, u8, Vec<u8>)>) {
    let folder = corpus(target);
    fs::create_dir_all(&folder).unwrap();
    for (name, settings, file) in inputs {
        assert!(file.len() < LONGEST, "{name}: {} bytes", file.len());
        fs::write(folder.join(name), [&[settings], &file[..]].concat()).unwrap();
    }
}

/// The files of a folder of `tests/faults`, unless they are long, with settings in turn.
fn faults(folder: &str, extension: &str, settings: &[u8]) -> Vec<(String, u8, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/faults").join(folder);
    let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let name = |path: &Path| path.file_name().unwrap().to_str().unwrap().to_owned();
    (paths.iter().filter(|path| path.extension().is_some_and(|e| e == extension)))
        .map(|path| (name(path), fs::read(path).unwrap()))
        .filter(|(_, file)| file.len() < LONGEST)
        .enumerate()
        .map(|(i, (name, file))| (name, settings[i % settings.len()], file))
        .collect()
}

#[test]
#[ignore = "writes into fuzz/corpus"]
fn write_the_seeds() {
    meshes();
    pictures();
    merl();
    stored();
}

fn tetrahedron() -> Mesh {
    let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]].map(Vector3::from);
    Mesh::new(corners.to_vec(), vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).unwrap()
}

fn meshes() {
    // y up and repaired in three of four.
    let settings = b"0102030405";
    let mesh = tetrahedron();
    let far = tetrahedron().with_origin(Vector3::new(5e5, 5.4e6, 0.0)).unwrap();
    let colours = vec![Vector3::repeat(0.5); 4];
    let mut big = b"ply\nformat binary_big_endian 1.0\nelement vertex 4\nproperty double x\nproperty double y\n\
        property double z\nelement face 2\nproperty list uchar ushort vertex_index\nproperty list uchar float uv\n\
        end_header\n"
        .to_vec();
    for c in [0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 2.0, 0.0, 0.0, 2.0, 0.0_f64] {
        big.extend(c.to_be_bytes());
    }
    for corners in [&[0, 1, 2, 3][..], &[2, 1, 0]] {
        big.push(corners.len() as u8);
        corners.iter().for_each(|&c: &u16| big.extend(c.to_be_bytes()));
        big.extend([1, 0x3f, 0x80, 0, 0]);
    }
    let ascii = "ply\nformat ascii 1.0\ncomment a plate and a flag\nelement vertex 7\nproperty float x\n\
        property float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n\
        element face 2\nproperty list uchar int vertex_indices\nelement edge 1\nproperty int a\nproperty int b\n\
        end_header\n0 0 0 0 0 1\n2 0 0 0 0 1\n2 2 0 0 0 1\n0.5 0.5 0 0 0 1\n0 2 0 0 0 1\n5 0 1e3 0 0 0\n5 1 0 1 0 0\n\
        5 0 1 2 3 4\n3 1 5 6\n0 1\n";
    let generated = [
        ("little.ply", encode_ply(&mesh, None).unwrap()),
        ("colours.ply", encode_ply(&mesh, Some(&colours)).unwrap()),
        ("far.ply", encode_ply(&far, None).unwrap()),
        ("big.ply", big),
        ("ascii.ply", ascii.into()),
    ];
    write("ply", faults("ply", "ply", settings));
    write("ply", generated.map(|(name, file)| (name.into(), b'0', file)));

    write("obj", faults("", "obj", settings));
    let text = "mtllib a.mtl\no one\nv 0 0 0\nv 2 0 0\nv 2 2 0 1.0\nv 0.5 0.5 0\nv 0 2 0\nvn 0 0 1\nvt 0 0\ng a\ns 1\n\
        usemtl red\nf 1/1/1 2/1/1 3//1 4//1 5//1\ns off\nf -5 -4 -2\nl 1 2\np 1\n";
    write("obj", [("all.obj".into(), b'0', text.into())]);

    write("gltf", faults("gltf", "gltf", settings));
    write("gltf", faults("gltf", "glb", settings));
    let json = r#"{"asset":{"version":"2.0"},"extensionsRequired":["KHR_mesh_quantization"],"nodes":[
        {"mesh":0,"scale":[2,1,-1],"children":[1]},{"mesh":0,"rotation":[0,0.6,0,0.8],"translation":[1e6,0,0]},
        {"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,3,0,0,1]}],"meshes":[{"primitives":[
        {"attributes":{"POSITION":0,"NORMAL":1},"mode":5}]}],"buffers":[{"byteLength":48}],"bufferViews":[
        {"buffer":0,"byteLength":32,"byteStride":8},{"buffer":0,"byteOffset":32,"byteLength":16,"byteStride":4}],
        "accessors":[{"bufferView":0,"componentType":5122,"count":4,"type":"VEC3"},
        {"bufferView":1,"componentType":5120,"normalized":true,"count":4,"type":"VEC3"}]}  "#;
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    let padded = json.len().next_multiple_of(4);
    glb.extend((12 + 8 + padded as u32 + 8 + 48).to_le_bytes());
    glb.extend((padded as u32).to_le_bytes());
    glb.extend(format!("JSON{json:padded$}").bytes());
    glb.extend(b"\x30\0\0\0BIN\0");
    for corner in [[0_i16, 0, 0, 0], [2, 0, 0, 0], [0, 2, 0, 0], [2, 2, 0, 0]] {
        corner.iter().for_each(|c| glb.extend(c.to_le_bytes()));
    }
    glb.extend([0, 0, 127, 0].repeat(4));
    write("gltf", [("strip.glb".into(), b'0', glb)]);
}

fn pictures() {
    // 21 … 27 read an environment of each layout, the others write: 0 … OpenEXR, 7 … HDR, 14 … PNG.
    let settings = b"\x15\x00\x07\x0e\x16\x17\x18\x19\x1a\x1b";
    let mut turn = settings.iter().copied().cycle();
    let mut seed = |name: String, file: Vec<u8>| (name, turn.next().unwrap(), file);
    let image = |w: usize, h: usize| {
        let pixel = |i: usize| Vector3::new((i % 5) as f32, 0.25 * (i / 7) as f32, if i % w > 4 { 1e4 } else { 0.0 });
        Image::new(w, h, (0..w * h).map(pixel).collect()).unwrap()
    };

    write("hdr", faults("pictures", "hdr", settings));
    for (w, h) in [(1, 1), (12, 6), (4, 3), (12, 2), (9, 9), (40, 3)] {
        write("hdr", [seed(format!("{w}x{h}.hdr"), encode_hdr(&image(w, h)).unwrap())]);
    }
    let head =
        "#?RGBE\nFORMAT=32-bit_rle_xyze\nEXPOSURE=2\nCOLORCORR=1 2 1\nPRIMARIES=0.7 0.3 0.2 0.7 0.1 0.1 0.3 0.3\n";
    let old =
        [head.as_bytes(), b"\n+X 2 -Y 3\n", b"\x80\x90\x70\x81\x01\x01\x01\x02", &b"\x10\x20\x30\x80".repeat(3)[..]];
    write("hdr", [seed("old_runs.hdr".into(), old.concat())]);

    write("exr", faults("pictures", "exr", settings));
    write("exr", [seed("written.exr".into(), encode_exr(&image(8, 4)).unwrap())]);
    for (i, compression) in COMPRESSIONS.into_iter().enumerate() {
        let (names, types, blocks) = match i % 3 {
            0 => (&["R", "G", "B"][..], &[SampleType::F16][..], Blocks::ScanLines),
            1 => (&["A", "R", "G", "B"][..], &[SampleType::F16, SampleType::F32][..], Blocks::ScanLines),
            _ => (&["Y", "Z"][..], &[SampleType::F32][..], Blocks::Tiles(Vec2(5, 8))),
        };
        let file = exr_file(names, types, compression, (9, 6), blocks, i % 2 == 0);
        write("exr", [seed(format!("compression_{i}.exr"), file)]);
    }
    // DWA treats half-float colours by their own code.
    let dwa = exr_file(&["R", "G", "B"], &[SampleType::F16], COMPRESSIONS[8], (12, 9), Blocks::ScanLines, false);
    write("exr", [seed("dwa_colours.exr".into(), dwa)]);

    write("png", [seed("written.png".into(), encode_png_srgb8(4, 3, &[[200, 100, 0]; 12]).unwrap())]);
    let five = |x: f64| ((x * 1e5) as u32).to_be_bytes().to_vec();
    let chromaticities = [0.3127, 0.329, 0.708, 0.292, 0.17, 0.797, 0.131, 0.046].map(five).concat();
    let profile = [&b"sRGB built-in\0\0"[..], &compress_to_vec_zlib(b"desc\0\0\0\0sRGB", 6)].concat();
    let palette: Vec<u8> = (0..12).map(|i| i * 20).collect();
    // Name, depth, colour type, interlacing, chunks.
    type Chunk = (&'static [u8; 4], Vec<u8>);
    let kinds: [(&str, u8, u8, u8, Vec<Chunk>); 11] = [
        ("grey_1", 1, 0, 0, vec![]),
        ("grey_2_gamma", 2, 0, 0, vec![(b"gAMA", five(1.0))]),
        ("grey_4_transparent", 4, 0, 0, vec![(b"tRNS", vec![0, 5])]),
        ("grey_16", 16, 0, 1, vec![(b"cICP", vec![9, 16, 0, 1])]),
        ("rgb_8_chromaticities", 8, 2, 0, vec![(b"gAMA", five(0.5)), (b"cHRM", chromaticities)]),
        ("rgb_16", 16, 2, 0, vec![(b"sRGB", vec![0])]),
        ("palette_2", 2, 3, 0, vec![(b"PLTE", palette.clone()), (b"tRNS", vec![255, 0])]),
        ("palette_8", 8, 3, 1, vec![(b"PLTE", palette)]),
        ("grey_alpha_8", 8, 4, 0, vec![(b"iCCP", profile)]),
        ("rgba_8", 8, 6, 1, vec![(b"tEXt", b"Title\0none".to_vec())]),
        ("rgba_16", 16, 6, 0, vec![]),
    ];
    for (name, depth, colour, interlaced, chunks) in kinds {
        let channels = [1, 0, 3, 1, 2, 0, 4][usize::from(colour)];
        write("png", [seed(format!("{name}.png"), png(6, 6, (depth, colour, interlaced), channels, &chunks))]);
    }
}

/// A picture of which each row is filtered in another way; the samples of palettes are below 4.
fn png(
    w: usize,
    h: usize,
    (depth, colour, interlaced): (u8, u8, u8),
    channels: usize,
    chunks: &[(&[u8; 4], Vec<u8>)],
) -> Vec<u8> {
    let mut out = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |name: &[u8; 4], data: &[u8]| {
        out.extend((data.len() as u32).to_be_bytes());
        let named = [&name[..], data].concat();
        out.extend_from_slice(&named);
        out.extend(crc32fast::hash(&named).to_be_bytes());
    };
    let sides = [w as u32, h as u32].map(u32::to_be_bytes).concat();
    chunk(b"IHDR", &[&sides[..], &[depth, colour, 0, 0, interlaced]].concat());
    chunks.iter().for_each(|(name, data)| chunk(name, data));
    let mut raw = Vec::new();
    let mut rows = |w: usize, h: usize| {
        if w == 0 || h == 0 {
            return;
        }
        let bytes = (w * channels * usize::from(depth)).div_ceil(8);
        for y in 0..h {
            // Filters add up what was before, which palettes must not.
            raw.push(if colour == 3 { 0 } else { (y % 5) as u8 });
            raw.extend((0..bytes).map(|x| ((x + y) % 4) as u8));
        }
    };
    if interlaced == 1 {
        for (x, y, dx, dy) in
            [(0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2)]
        {
            rows((w + dx - 1 - x) / dx, (h + dy - 1 - y) / dy);
        }
    } else {
        rows(w, h);
    }
    chunk(b"IDAT", &compress_to_vec_zlib(&raw, 6));
    chunk(b"IEND", &[]);
    out
}

fn merl() {
    let header: Vec<u8> = [90, 90, 180].map(i32::to_le_bytes).concat();
    let numbers = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>();
    let edit = |place: u32, value: f64| [&place.to_le_bytes()[..], &value.to_le_bytes()].concat();
    write(
        "merl",
        [
            ("empty".into(), b'r', Vec::new()),
            ("header".into(), b'r', header.clone()),
            ("some_numbers".into(), b'r', [header, vec![0; 80]].concat()),
            ("other_size".into(), b'r', [4, 4, 8].map(i32::to_le_bytes).concat()),
            ("directions".into(), b'd', numbers(&[0.0, 0.0, 1.0, 0.6, 0.0, 0.8, -0.6, 0.0, 0.8, 0.0, 1.0, 0.0])),
            ("below".into(), b'd', numbers(&[0.0, 0.0, -1.0, 0.6, 0.8, 1e-30, f32::NAN, 0.0, 1.0, 0.0, 0.0, 0.0])),
        ],
    );
    write(
        "merl_edits",
        [
            ("nan".into(), b'e', edit(20, f64::NAN)),
            ("not_measured".into(), b'e', [edit(12, -1.0), edit(11_664_012, 1e300)].concat()),
            ("cut".into(), b'e', vec![3]),
            ("longer".into(), b'e', vec![3; 5]),
        ],
    );
}

/// Numbers in [−1, 1) without a pattern.
fn numbers(len: usize) -> Vec<f64> {
    let mut stream = Stream::new(5);
    (0..len).map(|_| stream.signed()).collect()
}

/// Settings of the target `store`.
const NARROW: u8 = b'0';
const WIDE: u8 = b'2';
const PLACES_16: u8 = b'4';
const PLACES_32: u8 = b'8';

fn stored() {
    fn put(name: &str, settings: u8, stored: &impl Stored) {
        let mut file = Vec::new();
        stored.write_to(&mut file).unwrap();
        write("store", [(name.into(), settings, file)]);
    }
    let (mut binary, mut medium, mut wide) = (
        CodedBinaryMaps::<u8>::new(100).unwrap(),
        CodedBinaryMaps::<u16>::new(300).unwrap(),
        CodedBinaryMaps::<u32>::new(70_000).unwrap(),
    );
    let (mut gray, mut gray_medium) =
        (CodedGrayMaps::<u8>::new(64, 15).unwrap(), CodedGrayMaps::<u16>::new(300, 255).unwrap());
    for (k, numbers) in numbers(4 * 300).chunks(300).enumerate() {
        let bits: Vec<bool> = numbers.iter().map(|x| x.abs() < 0.2 * k as f64).collect();
        binary.push_bools(&bits[..100]);
        medium.push_bools(&bits);
        wide.push_bools(&(0..70_000).map(|i| i % 30_000 > 1000 * k).collect::<Vec<_>>());
        gray.push_levels(&numbers[..64].iter().map(|x| (x.abs() * 15.9) as u8 / 4 * 4).collect::<Vec<_>>());
        gray_medium.push_levels(&numbers.iter().map(|x| (x.abs() * 3.9) as u8 * 80).collect::<Vec<_>>());
    }
    put("binary_8", NARROW, &binary);
    put("binary_16", PLACES_16, &medium);
    put("binary_32", PLACES_32, &wide);
    put("binary_none", NARROW, &CodedBinaryMaps::<u8>::new(1).unwrap());
    put("gray_8", NARROW, &gray);
    put("gray_16", PLACES_16, &gray_medium);

    let triplets = (0..8).flat_map(|j| (0..6).map(move |k| (j, k, [0, 3, 3, -1, 2][(j * k + j / 3) % 5])));
    let matrix = SparseMatrix::from_triplets(8, 6, 0.25, triplets).unwrap();
    put("biclustering", NARROW, &Biclustering::new(&matrix, &BiclusterSettings::default(), &()).unwrap());

    let values = numbers(12 * 5);
    let narrow: Vec<f32> = values.iter().map(|&x| x as f32).collect();
    put("pca_64", WIDE, &Pca::new(&values, 5, &PcaSettings::new(2)).unwrap());
    put("pca_32", NARROW, &Pca::new(&narrow, 5, &PcaSettings::new(2)).unwrap());
    put("clusters_64", WIDE, &ClusteredPca::new(&values, 5, &ClusteredPcaSettings::new(2, 0), &()).unwrap());
    put("clusters_32", NARROW, &ClusteredPca::new(&narrow, 5, &ClusteredPcaSettings::new(3, 1), &()).unwrap());
    put("half", NARROW, &QuantisedHalf::new(&values).unwrap());
    put("bytes_rows", WIDE, &QuantisedBytes::new(&values, 5, ByteBlocks::Rows).unwrap());
    put("bytes_columns", NARROW, &QuantisedBytes::new(&narrow, 5, ByteBlocks::Columns).unwrap());
    put("bytes_runs", NARROW, &QuantisedBytes::new(&narrow, 5, ByteBlocks::Runs(7)).unwrap());

    let mesh = tetrahedron();
    let bake = |side: usize| -> BinaryVisibility {
        let baker = VisibilityBaker::new(&mesh, CubeGrid::new(side).unwrap(), VisibilitySettings::default());
        baker.unwrap().bake(&()).unwrap()
    };
    let red: Arc<dyn Brdf> = Arc::new(Lambert::new([0.7, 0.2, 0.1]).unwrap());
    let gloss: Arc<dyn Brdf> = Arc::new(Phong::new([0.3; 3], 20.0).unwrap());
    let materials = Materials::new(vec![red, gloss], vec![0, 1, 0, 1]).unwrap();
    let view = View::eye(Vector3::new(2.0, 3.0, 5.0)).unwrap();
    for (name, precision) in [
        ("double_32", wavelet_double::Precision::Full),
        ("double_16", wavelet_double::Precision::Bits16),
        ("double_8", wavelet_double::Precision::Bits8),
    ] {
        let settings = wavelet_double::BakeSettings { tolerance: 0.1, precision };
        let transport = wavelet_double::Transport::bake(&mesh, &bake(4), &view, &materials, settings, &());
        put(name, NARROW, &transport.unwrap());
    }
    let small = near_field::BakeSettings { cells: 4, samples: 1, tolerance: 0.2, ..Default::default() };
    let occluders = Arc::new(Occluders::of_mesh(&mesh));
    for (name, precision) in [("near_32", near_field::Precision::Full), ("near_16", near_field::Precision::Bits16)] {
        let settings = near_field::BakeSettings { precision, ..small };
        let transport = near_field::Transport::bake(&mesh, occluders.clone(), &view, &materials, settings, &());
        put(name, NARROW, &transport.unwrap());
    }
    let factors = near_field::ViewFactors { cells: 2, terms: 2 };
    let free = near_field::Transport::bake_view_free(&mesh, occluders, &materials, factors, small, &());
    put("near_free", NARROW, &free.unwrap());
    put("triple", NARROW, &wavelet_triple::Transport::from_binary(bake(8)).unwrap());
    for (name, side, order) in [("block_8", 8, ScanOrder::Serpentine), ("block_32", 32, ScanOrder::Hilbert)] {
        let layout = block_product::BlockLayout::new(CubeGrid::new(side).unwrap(), side, order).unwrap();
        put(name, NARROW, &block_product::Transport::from_binary(&mesh, &bake(side), &layout).unwrap());
    }
    let grid = CubeGrid::new(8).unwrap();
    let layout = block_product::BlockLayout::new(grid, 8, ScanOrder::RowMajor).unwrap();
    let baker = VisibilityBaker::new(&mesh, grid, VisibilitySettings::default()).unwrap();
    put("block_gray", NARROW, &block_product::Transport::bake_gray(&mesh, &baker, &layout, (2, 4), &()).unwrap());
}
