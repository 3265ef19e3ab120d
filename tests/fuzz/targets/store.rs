//! Readers of everything that can be stored.

use std::fmt::Debug;

use haarmonic::backend::{DistantRelighter, block_product, near_field, wavelet_double, wavelet_triple};
use haarmonic::compress::{
    Biclustering, ClusteredPca, CodedBinaryMaps, CodedGrayMaps, MapIndex, Pca, QuantisedBytes, QuantisedHalf,
};
use haarmonic::haar::Keep;
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{Lambert, Materials, Mesh, View};
use haarmonic::sphere::{CubeGrid, CubeMap};
use haarmonic::store::{Kind, Stored};
use haarmonic::{Error, Real};

use super::split;

/// A file of any kind; its own tag says of which, and the byte before it of which numbers.
///
/// The file gets the checksum that belongs to it and, if the byte of settings is even, its sections the lengths that
/// they have, so that damage goes beyond these.
pub fn store(data: &[u8]) {
    let (settings, file) = split(data);
    let mut file = file.to_vec();
    let Some(kind) = file.get(10..14).and_then(|tag| Kind::from_tag([tag[0], tag[1], tag[2], tag[3]])) else {
        // No file of ours; any reader will do to say so.
        return check_refused::<Pca<f64>>(&file);
    };
    if settings % 2 == 0 {
        mend_lengths(&mut file);
    }
    if let Some(end) = file.len().checked_sub(4) {
        let checksum = crc32fast::hash(&file[..end]);
        file[end..].copy_from_slice(&checksum.to_le_bytes());
    }
    let (wide, index) = (settings / 2 % 2 == 1, settings / 4 % 3);
    match (kind, index) {
        (Kind::CodedBinaryMaps, 0) => read(&file, binary_maps::<u8>),
        (Kind::CodedBinaryMaps, 1) => read(&file, binary_maps::<u16>),
        (Kind::CodedBinaryMaps, _) => read(&file, binary_maps::<u32>),
        (Kind::CodedGrayMaps, 0) => read(&file, gray_maps::<u8>),
        (Kind::CodedGrayMaps, 1) => read(&file, gray_maps::<u16>),
        (Kind::CodedGrayMaps, _) => read(&file, gray_maps::<u32>),
        (Kind::Biclustering, _) => read(&file, biclustering),
        (Kind::Pca, _) if wide => read(&file, pca::<f64>),
        (Kind::Pca, _) => read(&file, pca::<f32>),
        (Kind::ClusteredPca, _) if wide => read(&file, clustered_pca::<f64>),
        (Kind::ClusteredPca, _) => read(&file, clustered_pca::<f32>),
        (Kind::QuantisedHalf, _) => read(&file, quantised_half),
        (Kind::QuantisedBytes, _) if wide => read(&file, quantised_bytes::<f64>),
        (Kind::QuantisedBytes, _) => read(&file, quantised_bytes::<f32>),
        (Kind::WaveletDouble, _) => read(&file, double),
        (Kind::WaveletTriple, _) => read(&file, triple),
        (Kind::NearField, _) => read(&file, near),
        // The largest cube maps have layouts of 50 MB.
        (Kind::BlockProduct, _) if number(&file, 30).is_some_and(|side| (65..=1024).contains(&side)) => {}
        (Kind::BlockProduct, _) => read(&file, block),
        (kind, _) => panic!("no target for {kind:?}"),
    }
}

const HEADER: usize = 18;

fn number(file: &[u8], at: usize) -> Option<u64> {
    file.get(at..)?.first_chunk().map(|bytes| u64::from_le_bytes(*bytes))
}

/// Writes into the head of every section where the next one begins, as its tag shows.
fn mend_lengths(file: &mut [u8]) {
    const TAGS: [&[u8; 4]; 17] = [
        b"SIZE", b"DATA", b"ROWS", b"COLS", b"BASE", b"DIST", b"BITS", b"CODE", b"BLOK", b"WORD", b"MAPS", b"PART",
        b"PATH", b"FACE", b"POSN", b"FREE", b"END.",
    ];
    let mut at = HEADER;
    while at + 12 <= file.len() {
        let next =
            (at + 12..file.len().saturating_sub(11)).find(|&i| TAGS.iter().any(|tag| file[i..].starts_with(*tag)));
        let end = next.unwrap_or(file.len());
        file[at + 4..at + 12].copy_from_slice(&((end - at - 12) as u64).to_le_bytes());
        at = end;
    }
}

/// Whether there are sections that a reader skips.
fn has_more(file: &[u8]) -> bool {
    let mut at = HEADER;
    while let Some(length) = number(file, at + 4) {
        if file[at].is_ascii_lowercase() {
            return true;
        }
        at = at.saturating_add(12).saturating_add(length as usize);
        if at >= file.len() {
            break;
        }
    }
    false
}

fn check_refused<S: Stored + Debug>(file: &[u8]) {
    match S::read_from(file) {
        Err(Error::File { .. }) => {}
        other => panic!("{other:?}"),
    }
}

/// What can be read can be written and is the same, byte for byte; then it is used.
fn read<S: Stored + PartialEq + Debug>(file: &[u8], then: impl FnOnce(&S)) {
    let stored = match S::read_from(file) {
        Ok(stored) => stored,
        Err(error) => return assert!(matches!(error, Error::File { .. }), "{error:?}"),
    };
    let mut written = Vec::new();
    stored.write_to(&mut written).expect("memory takes all bytes");
    let again = S::read_from(&written[..]).expect("what is written can be read");
    assert!(again == stored, "{again:?} is not {stored:?}");
    assert!(written == file || has_more(file), "written otherwise than read: {stored:?}");
    then(&stored);
}

/// Longer ones are read, but nothing more is done with them.
const LONG: usize = 1 << 12;

fn binary_maps<I: MapIndex>(maps: &CodedBinaryMaps<I>) {
    assert_eq!(maps.stats().changes, maps.total_changes());
    if maps.map_len() > LONG {
        return;
    }
    let (mut numbers, mut bits) = (vec![0.0_f32; maps.map_len()], vec![0; maps.map_len().div_ceil(64)]);
    let sums: Vec<f32> = (0..maps.map_len()).map(|i| (maps.map_len() - i) as f32).collect();
    for map in maps.iter() {
        map.decode(&mut numbers);
        map.decode_bits(&mut bits);
        let ones = map.count_ones();
        assert_eq!(bits.iter().map(|word| word.count_ones() as usize).sum::<usize>(), ones);
        assert_eq!((numbers.iter().sum::<f32>(), map.dot(&sums)), (ones as f32, ones as f32));
    }
}

fn gray_maps<I: MapIndex>(maps: &CodedGrayMaps<I>) {
    assert_eq!(maps.stats().changes, maps.total_changes());
    if maps.map_len() > LONG {
        return;
    }
    let (mut numbers, mut levels) = (vec![0.0_f32; maps.map_len()], vec![0; maps.map_len()]);
    let mut again = CodedGrayMaps::<I>::new(maps.map_len(), maps.top()).expect("there are such maps");
    for map in maps.iter() {
        map.decode(&mut numbers);
        map.decode_levels(&mut levels);
        assert!(levels.iter().all(|&level| level <= maps.top()));
        assert!(numbers.iter().all(|x| (0.0..=1.0).contains(x)));
        again.push_levels(&levels);
    }
    assert!(again == *maps, "{again:?} is not {maps:?}");
}

fn biclustering(biclusters: &Biclustering) {
    let (rows, columns) = (biclusters.rows(), biclusters.columns());
    if rows > LONG || columns > LONG {
        return;
    }
    let matrix = biclusters.to_matrix();
    assert_eq!(2 * matrix.nnz(), biclusters.stats().matrix_flops);
    for sides in [1, 3] {
        let x = vec![1.0_f64; columns * sides];
        let [mut direct, mut fast] = [(); 2].map(|()| vec![f64::NAN; rows * sides]);
        matrix.multiply_batch(sides, &x, &mut direct);
        let multiplier = biclusters.multiplier::<f64>();
        multiplier.multiply_batch(sides, &x, &mut fast, &mut vec![0.0; multiplier.scratch_len(sides)]);
        // Sums of levels are whole numbers: exact, times the scale. It may overflow.
        let near = |(a, b): (&f64, &f64)| a == b || (a - b).abs() <= 1e-9 * a.abs().max(b.abs()) || !a.is_finite();
        assert!(direct.iter().zip(&fast).all(near), "{direct:?} {fast:?}");
    }
}

fn pca<T: Real>(pca: &Pca<T>) {
    let rows = vec![T::one(); 2 * pca.columns()];
    let mut weights = vec![T::zero(); 2 * pca.len()];
    pca.project(&rows, &mut weights);
    let mut out = rows;
    pca.reconstruct(&weights, &mut out);
}

fn clustered_pca<T: Real>(pca: &ClusteredPca<T>) {
    let (rows, columns) = (pca.rows(), pca.columns());
    let mut row = vec![T::zero(); columns];
    (0..rows.min(4)).for_each(|r| pca.reconstruct(r, &mut row));
    let x = vec![T::one(); 3 * columns];
    let mut out = vec![T::zero(); 3 * rows];
    pca.multiply_batch(3, &x, &mut out, &mut vec![T::zero(); pca.scratch_len(3)]);
    let (mut labels, mut weights) = (vec![0; 1], vec![T::zero(); pca.components()]);
    pca.encode(&x[..columns], &mut labels, &mut weights).expect("ones are finite");
    assert!((labels[0] as usize) < pca.clusters());
    assert!(pca.stats().clusters == pca.clusters());
}

fn quantised_half(numbers: &QuantisedHalf) {
    let mut out = vec![f32::NAN; numbers.bits().len()];
    numbers.decode(&mut out);
    assert!(out.iter().all(|x| x.is_finite()));
}

fn quantised_bytes<T: Real>(numbers: &QuantisedBytes<T>) {
    let mut out = vec![T::of(f64::NAN); numbers.len()];
    numbers.decode(&mut out);
    assert!(out.iter().all(|x| x.is_finite()));
}

fn double(transport: &wavelet_double::Transport) {
    assert!(transport.stats().vertices == transport.vertices());
    if transport.grid().side() > 16 || transport.vertices() > LONG {
        return;
    }
    let settings = wavelet_double::Settings { light_terms: Keep::Fraction(1.0), ..Default::default() };
    let relighter = wavelet_double::Relighter::new(transport, settings).expect("the settings are good");
    relight(relighter, transport.view().copied());
}

fn near(transport: &near_field::Transport) {
    assert!(transport.stats().vertices == transport.vertices());
    if transport.face().cells() > 16 || transport.vertices() > LONG {
        return;
    }
    let lamp = near_field::PlanarLight::uniform(Vector3::new(0.3, 4.0, 0.2), [2.0, 1.0], Vector3::repeat(1.0));
    let lamp = lamp.expect("the lamp is good").with_rotation(0.3).expect("the angle is one");
    for route in [near_field::Route::Couplings, near_field::Route::Pixels] {
        let settings = near_field::Settings { source_side: 8, route, ..Default::default() };
        let mut relighter = near_field::Relighter::new(transport, settings).expect("the settings are good");
        relighter.set_lights(std::slice::from_ref(&lamp)).expect("the lamp is good");
        if transport.is_view_free() {
            let view = View::eye(Vector3::new(1.0, 2.0, 3.0)).expect("an eye");
            relighter.set_view(&view).expect("the view is free");
        }
        let mut out = vec![Vector3::repeat(f32::NAN); transport.vertices()];
        relighter.relight(&mut out);
        assert!(out.iter().all(|l| l.iter().all(|c| c.is_finite())));
    }
}

fn triple(transport: &wavelet_triple::Transport) {
    assert!(transport.stats().vertices == transport.vertices());
    if let Some(mesh) = mesh(transport.grid(), transport.vertices()) {
        let relighter = wavelet_triple::Relighter::new(&mesh, transport, Default::default()).expect("it fits");
        relight(relighter, None);
    }
}

fn block(transport: &block_product::Transport) {
    assert!(transport.stats().vertices == transport.vertices());
    let mut texels = vec![f32::NAN; transport.layout().grid().len()];
    for vertex in 0..transport.vertices().min(4) {
        transport.decode(vertex, &mut texels);
        assert!(texels.iter().all(|x| (0.0..=1.0).contains(x)));
    }
    if let Some(mesh) = mesh(transport.layout().grid(), transport.vertices()) {
        let settings = block_product::Settings { rule: block_product::Rule::Pixels, ..Default::default() };
        let relighter = block_product::Relighter::new(&mesh, transport, settings).expect("it fits");
        relight(relighter, None);
    }
}

/// A mesh of so many vertices, if a frame of it takes no long time.
fn mesh(grid: CubeGrid, vertices: usize) -> Option<Mesh> {
    if grid.side() > 8 || !(3..=8).contains(&vertices) {
        return None;
    }
    let positions = (0..vertices).map(|v| Vector3::new((v % 2) as f32, v as f32, (v / 2) as f32)).collect();
    Some(Mesh::new(positions, vec![[0, 1, 2]]).expect("three vertices are there"))
}

fn relight(mut relighter: impl DistantRelighter, view: Option<View>) {
    let view = view.unwrap_or_else(|| View::towards(Vector3::y()).expect("a direction"));
    let materials = Materials::uniform(Lambert::new([0.5; 3]).expect("albedos are in [0, 1]"));
    relighter.set_light(&CubeMap::from_fn(relighter.grid(), |_| Vector3::new(1.0, 2.0, 3.0))).expect("it is finite");
    let mut out = vec![Vector3::repeat(f32::NAN); relighter.vertices()];
    relighter.relight(&view, &materials, &mut out).expect("view and materials are good");
    assert!(out.iter().all(|l| l.iter().all(|c| c.is_finite())), "{out:?}");
}
