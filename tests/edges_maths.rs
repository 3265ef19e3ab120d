//! What the mathematics makes of sizes and numbers at the ends of their range: one table of constructors, one of
//! values, one of calls that are documented to panic.

use std::panic::{AssertUnwindSafe, catch_unwind};

use haarmonic::affine::{
    AffineMap, AffineProduct1d, AffineProduct2d, Atom, CanonicalTable, Filter, Heuristic, LightField, MapGrid, Mother,
    Nonzeros1d, NonzerosNonstandard, Operator1d, Prediction, Propagation, PropagationSource, Quantisation,
    StoredCouplings, Targets, TripleNonzeros1d, TripleNonzerosNonstandard, apply_map_1d, canonical, canonical_gradient,
    coupling, coupling_1d, coupling_gradient, coupling_gradient_1d, mean_squares_1d, mean_squares_2d, tripling,
    tripling_1d,
};
use haarmonic::compress::{
    BiclusterSettings, Biclustering, ByteBlocks, ClusteredPca, ClusteredPcaSettings, CodedBinaryMaps, CodedGrayMaps,
    Distortion, Pca, PcaSettings, QuantisedBytes, QuantisedHalf, Scan, ScanOrder, SparseMatrix, half_to_real,
    real_to_half,
};
use haarmonic::dct::{BlockDct, LowProjection};
use haarmonic::haar::{
    BinaryTree, BitPyramid, Decomposition, Keep, MaskedSum, MeanTree, Product1d, Product2d, Pyramid, Quadtree,
    Selection, SparseVector, Transform1d, Transform2d, TripleProduct, Weighting, forward_1d, forward_2d, select,
    transport_weights, tripling_1d as haar_tripling_1d, tripling_2d, tripling_count_1d, tripling_count_2d,
    tripling_nonzeros_1d, tripling_nonzeros_2d,
};
use haarmonic::nalgebra::{Matrix3, Rotation3, Vector3};
use haarmonic::numeric::{CompensatedSum, GaussLegendre, legendre, safe_acos, safe_asin, safe_sqrt};
use haarmonic::reference::affine::fourier_basis::{fourier_coupling, fourier_tripling_count};
use haarmonic::reference::affine::pixel_basis::{pixel_coupling, pixel_coupling_bound};
use haarmonic::reference::haar::NgTree;
use haarmonic::sphere::{
    CubeGrid, CubeMap, Face, HemisphereDisk, LatLongGrid, LatLongMap, Resampling, SphereQuadrature,
    fibonacci_directions,
};
use haarmonic::table::{
    Border, Coverage, DiskGrid, Outside, Rectangle, SummedArea, SummedAreaPlan, SummedAreaStack, VisibilityDistance,
    VisibilityDistancePlan, half_plane_coverage, linear_coverage, mean_coverage, smoothstep_coverage,
};
use haarmonic::{Error, Result};

const NAN: f64 = f64::NAN;
const INF: f64 = f64::INFINITY;
const MAX: f64 = f64::MAX;
/// The smallest number.
const TINY: f64 = 5e-324;
const HUGE: usize = usize::MAX;

/// What a constructor must say.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Says {
    Fine,
    Range,
    Power,
    Length,
    Empty,
    NotFinite,
}
use Says::{Empty, Fine, Length, NotFinite, Power, Range};

fn says(result: &Result<()>) -> Says {
    match result {
        Ok(()) => Fine,
        Err(Error::OutOfRange { .. }) => Range,
        Err(Error::NotPowerOfTwo { .. }) => Power,
        Err(Error::Length { .. }) => Length,
        Err(Error::Empty { .. }) => Empty,
        Err(Error::NotFinite { .. }) => NotFinite,
        Err(other) => panic!("{other:?}"),
    }
}

type Constructor<'a> = (&'static str, Box<dyn Fn() -> Result<()> + 'a>, Says);

/// A row of the table: its text, what it makes (dropped), what it must say.
macro_rules! made {
    ($($make:expr => $says:expr),* $(,)?) => {
        vec![$((stringify!($make), Box::new(|| $make.map(drop)) as Box<dyn Fn() -> Result<()>>, $says)),*]
    };
}

/// Makes everything; all that is wrong is told at once. What is refused must not have taken memory for it.
#[track_caller]
fn check(table: Vec<Constructor>) {
    let mut wrong = Vec::new();
    for (text, make, want) in table {
        let mut got = None;
        let memory = allocation_counter::measure(|| got = Some(catch_unwind(AssertUnwindSafe(&make))));
        match got.expect("it ran") {
            Err(_) => wrong.push(format!("{text}: panics")),
            Ok(result) if says(&result) != want => wrong.push(format!("{text}: {result:?}, want {want:?}")),
            Ok(Err(_)) if memory.bytes_max > 1 << 16 => wrong.push(format!("{text}: takes {} bytes", memory.bytes_max)),
            Ok(Err(error)) if error.to_string().contains("NaN,") => wrong.push(format!("{text}: says {error}")),
            Ok(_) => {}
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn sparse(len: usize) -> SparseVector<f64> {
    SparseVector::new(len, vec![], vec![]).unwrap()
}

fn grid(side: usize) -> MapGrid {
    MapGrid::new([0.5, 2.0], [side, side]).unwrap()
}

const STANDARD: Decomposition = Decomposition::Standard;
const NONSTANDARD: Decomposition = Decomposition::Nonstandard;
const ID: AffineMap = AffineMap::IDENTITY;

#[test]
fn affine_constructors() {
    check(made![
        AffineMap::new(0.0, 0.0) => Range,
        AffineMap::new(-0.0, 0.0) => Range,
        AffineMap::new(NAN, 0.0) => Range,
        AffineMap::new(INF, 0.0) => Range,
        AffineMap::new(TINY, 0.0) => Range,
        AffineMap::new(MAX, 0.0) => Range,
        AffineMap::new(1e-100, 1e100) => Fine,
        AffineMap::new(-1e100, -1e100) => Fine,
        AffineMap::new(1.0, NAN) => Range,
        AffineMap::new(1.0, -INF) => Range,
        AffineMap::new(1.0, MAX) => Range,
        AffineMap::new(1.0, TINY) => Fine,
        AffineMap::new(1e-100, 0.0).and_then(|m| m.then(m)) => Range,
        AffineMap::new(1e100, 1e100).and_then(|m| m.then(m)) => Range,
        MapGrid::new([NAN, 1.0], [4, 4]) => Range,
        MapGrid::new([1.0, INF], [4, 4]) => Range,
        MapGrid::new([2.0, 1.0], [4, 4]) => Range,
        MapGrid::new([-1.0, 1.0], [4, 4]) => Range,
        MapGrid::new([1.0, 1.0], [4, 4]) => Range,
        MapGrid::new([1e-100, 1e100], [4, 4]).map(|g| (0..4).map(|k| g.map(k, k).scale()).sum::<f64>()) => Fine,
        MapGrid::new([-1e100, -1e-100], [3, 65536]).map(|g| g.map(2, 65535)) => Fine,
        MapGrid::new([0.5, 2.0], [0, 4]) => Range,
        MapGrid::new([0.5, 2.0], [4, HUGE]) => Range,
        Nonzeros1d::new(0) => Power,
        Nonzeros1d::new(HUGE) => Power,
        Nonzeros1d::new(1 << 63).map(|n| n.row(0, ID, |_, _| {})) => Fine,
        NonzerosNonstandard::new(HUGE) => Range,
        NonzerosNonstandard::new(0) => Power,
        TripleNonzeros1d::new(0) => Power,
        TripleNonzerosNonstandard::new(1 << 62) => Range,
        Operator1d::<f32>::new(0, ID) => Power,
        Operator1d::<f32>::new(1 << 25, ID) => Range,
        Operator1d::<f64>::new(1 << 63, ID) => Range,
        Operator1d::<f64>::new(1, ID) => Fine,
        apply_map_1d::<f64>(&[], ID) => Power,
        apply_map_1d(&[NAN, 1.0], ID) => Fine,
        Propagation::<f32>::new(HUGE, STANDARD) => Range,
        Propagation::<f32>::new(0, STANDARD) => Power,
        Targets::all(1 << 63, NONSTANDARD) => Range,
        Targets::new(2, NONSTANDARD, &[u32::MAX]) => Range,
        PropagationSource::new(1 << 40, STANDARD, [&sparse(0)]) => Range,
        PropagationSource::new(1024, STANDARD, [&sparse(4)]) => Length,
        AffineProduct1d::new(&sparse(0)) => Power,
        AffineProduct1d::new(&sparse(1 << 40)) => Range,
        AffineProduct1d::new(&sparse(1 << 63)) => Range,
        AffineProduct2d::new([&sparse(1 << 40)]) => Range,
        AffineProduct2d::new([&sparse(1 << 62)]) => Range,
        AffineProduct2d::new([&sparse(HUGE)]) => Power,
        AffineProduct2d::<0>::new::<f32>([]) => Empty,
        LightField::new(HUGE) => Range,
        LightField::new(0) => Power,
        StoredCouplings::new(1 << 40, grid(4), HUGE) => Range,
        StoredCouplings::new(0, grid(4), HUGE) => Power,
        StoredCouplings::new(2, grid(2), 0) => Range,
        CanonicalTable::new(0, Quantisation::F32) => Range,
        CanonicalTable::new(HUGE, Quantisation::F32) => Range,
        CanonicalTable::new(HUGE - 3, Quantisation::F32) => Range,
        Prediction::<1>::new(1 << 40, Heuristic::Constant, grid(2), Keep::Terms(1)) => Range,
        Prediction::<1>::new(1 << 63, Heuristic::Constant, grid(2), Keep::Terms(1)) => Range,
        Prediction::<2>::new(1 << 15, STANDARD, Heuristic::Constant, grid(2), Keep::Terms(1)) => Range,
        Prediction::<2>::new(4, STANDARD, Heuristic::Constant, grid(65536), Keep::Terms(1)) => Range,
        Prediction::<1>::new(2, Heuristic::Light(&[1.0, NAN]), grid(2), Keep::Terms(1)) => NotFinite,
        Prediction::<1>::new(2, Heuristic::Light(&[1.0]), grid(2), Keep::Terms(1)) => Length,
        Prediction::<1>::new(2, Heuristic::Power(&[1.0, -1.0]), grid(2), Keep::Terms(1)) => Range,
        Prediction::<1>::new(2, Heuristic::Power(&[1.0, INF]), grid(2), Keep::Terms(1)) => NotFinite,
        Prediction::<1>::new(2, Heuristic::Light(&[0.0, 0.0]), grid(2), Keep::Terms(HUGE)).map(|p| p.fill()) => Fine,
        Prediction::<1>::new(2, Heuristic::Constant, grid(2), Keep::Fraction(NAN)) => Range,
        Prediction::<1>::new(2, Heuristic::Constant, grid(2), Keep::Fraction(-0.1)) => Range,
        Prediction::<1>::new(2, Heuristic::Constant, grid(2), Keep::Fraction(INF)) => Range,
        Prediction::<1>::new(2, Heuristic::Constant, grid(2), Keep::Fraction(TINY)).map(|p| p.fill()) => Fine,
        Prediction::<1>::new(2, Heuristic::Constant, grid(1), Keep::Terms(1)).map(|p| p.with_samples(HUGE).fill()) => Fine,
        Prediction::<1>::new(2, Heuristic::Constant, grid(2), Keep::Terms(1)).map(|p| p.with_union(HUGE).fill()) => Fine,
        mean_squares_1d(1 << 62, &[]) => Range,
        mean_squares_1d(0, &[]) => Power,
        mean_squares_1d(2, &[&[1.0, NAN]]) => NotFinite,
        mean_squares_1d(2, &[&[1.0, 1e200]]) => Range,
        mean_squares_1d(2, &[&[1.0, TINY]]) => Fine,
        mean_squares_2d(1 << 32, STANDARD, &[]) => Range,
        mean_squares_2d(1 << 63, NONSTANDARD, &[]) => Range,
    ]);
}

#[test]
fn haar_constructors() {
    check(made![
        Transform1d::<f32>::new(0) => Power,
        Transform1d::<f32>::new(1 << 63).map(|t| t.scratch_len()) => Fine,
        Transform2d::<f32>::new(HUGE, 1, STANDARD) => Power,
        Transform2d::<f32>::new(1 << 63, 1 << 63, NONSTANDARD) => Range,
        Transform2d::<f32>::new(1 << 62, 1, STANDARD) => Range,
        Transform2d::<f32>::new(1, 2, NONSTANDARD) => Length,
        forward_1d::<f32>(&[]) => Power,
        forward_2d::<f32>(&[], 1 << 40, 1 << 40, STANDARD) => Range,
        forward_2d::<f32>(&[], 1 << 20, 1 << 20, STANDARD) => Length,
        Pyramid::<f64>::new(0) => Power,
        Pyramid::<f64>::new(1 << 30) => Range,
        Pyramid::<f64>::new(1 << 63) => Range,
        Pyramid::from_pixels(1 << 15, &[1.0]) => Length,
        Pyramid::from_coefficients(1 << 31, &[1.0]) => Range,
        MeanTree::<f64>::zeros(1 << 20) => Range,
        MeanTree::from_pixels(1 << 14, [&[1.0][..]]) => Length,
        MeanTree::from_coefficients(1 << 14, [&[1.0][..]]) => Length,
        MeanTree::from_sparse([&sparse(1 << 62)]) => Range,
        MeanTree::<f64, 0>::from_sparse([]) => Empty,
        NgTree::new(&sparse(1 << 62)) => Range,
        NgTree::new(&sparse(0)) => Power,
        BinaryTree::new(&sparse(1 << 63)) => Range,
        Quadtree::new(&sparse(1 << 62)) => Range,
        Quadtree::new(&sparse(2)) => Power,
        BitPyramid::zeros(HUGE) => Power,
        BitPyramid::zeros(1 << 63) => Range,
        BitPyramid::from_rows(4, &[]) => Length,
        TripleProduct::new(1 << 63) => Range,
        TripleProduct::new(0) => Power,
        Product1d::new(1 << 63) => Range,
        Product1d::new(0) => Power,
        Product2d::new(1 << 32) => Range,
        Product2d::new(1 << 31).map(|p| p.scratch_len()) => Fine,
        SparseVector::<f64>::new(HUGE, vec![u32::MAX], vec![NAN]) => Fine,
        SparseVector::<f64>::new(0, vec![0], vec![1.0]) => Range,
        SparseVector::from_pairs(HUGE, [(HUGE - 1, 1.0)]) => Range,
        tripling_count_1d(1 << 56) => Fine,
        tripling_count_1d(1 << 57) => Range,
        tripling_count_1d(1 << 62) => Range,
        tripling_count_1d(1 << 63) => Range,
        tripling_count_1d(HUGE) => Power,
        tripling_count_2d(1 << 28) => Fine,
        tripling_count_2d(1 << 31) => Range,
        tripling_count_2d(1 << 63) => Range,
        tripling_nonzeros_1d(1 << 63).map(|mut all| all.next()) => Fine,
        tripling_nonzeros_2d(1 << 31).map(|mut all| all.next()) => Fine,
        tripling_nonzeros_2d(1 << 32) => Range,
        select(&[1.0, 2.0], Keep::Fraction(NAN), Weighting::Magnitude) => Range,
        select(&[1.0, 2.0], Keep::Fraction(-1.0), Weighting::Magnitude) => Range,
        select(&[1.0, 2.0], Keep::Fraction(INF), Weighting::Magnitude) => Range,
        select(&[1.0, 2.0], Keep::Terms(HUGE), Weighting::Magnitude) => Fine,
        select(&[1.0, NAN], Keep::Terms(1), Weighting::Magnitude) => NotFinite,
        select(&[1.0, 2.0], Keep::Terms(1), Weighting::Transport(&[1.0, NAN])) => NotFinite,
        select(&[1.0, 2.0], Keep::Terms(1), Weighting::Transport(&[1.0, -1.0])) => Range,
        select::<f64>(&[], Keep::Terms(1), Weighting::Magnitude) => Fine,
        Selection::new(Keep::Terms(1)).with_blocks_of(0).apply(&[1.0]) => Range,
        Selection::new(Keep::Terms(1)).with_blocks_of(HUGE).apply(&[1.0]) => Length,
        "nan%".parse::<Keep>().map_err(|_| Error::Empty { what: "text" }) => Empty,
        "inf%".parse::<Keep>().map_err(|_| Error::Empty { what: "text" }) => Empty,
        transport_weights(2, [&sparse(3)]) => Length,
    ]);
}

#[test]
fn table_and_dct_constructors() {
    check(made![
        SummedAreaPlan::new(HUGE, HUGE) => Range,
        SummedAreaPlan::new(HUGE, 0) => Range,
        SummedAreaPlan::new(0, HUGE) => Range,
        SummedAreaPlan::new(0, 0) => Fine,
        SummedAreaPlan::new(1 << 32, 1 << 32) => Range,
        SummedArea::<f64>::new(1 << 20, 1 << 20, &[1.0f32]) => Length,
        SummedAreaStack::<f32>::new([HUGE, HUGE], HUGE, &[1.0f32]) => Range,
        SummedAreaStack::<f32>::new([HUGE, HUGE], 0, &[] as &[f32]) => Range,
        SummedAreaStack::<f32>::new([0, 0], HUGE, &[] as &[f32]) => Range,
        SummedAreaStack::<f32>::new([1 << 20, 1 << 20], 1, &[1.0f32]) => Length,
        VisibilityDistancePlan::new(HUGE, HUGE, Border::Open) => Range,
        VisibilityDistancePlan::new(HUGE, 0, Border::Zero) => Range,
        VisibilityDistancePlan::new(16_384, 16_384, Border::Zero) => Range,
        VisibilityDistance::new([0, 1], &[] as &[bool], Border::Open) => Empty,
        VisibilityDistance::new([16_383, 16_383], &[true][..], Border::Open) => Length,
        DiskGrid::new(0) => Empty,
        DiskGrid::new(HUGE) => Range,
        BlockDct::<f32>::new(0) => Power,
        BlockDct::<f32>::new(1 << 63) => Range,
        BlockDct::<f32>::tiles(16, HUGE - 15, HUGE) => Range,
        BlockDct::<f32>::tiles(16, 16, HUGE) => Range,
        BlockDct::<f32>::tiles(16, 0, 16) => Range,
        LowProjection::<f64>::centres(HUGE, 2) => Range,
        LowProjection::<f64>::centres(4, HUGE) => Range,
        LowProjection::<f64>::centres(0, 0) => Range,
        LowProjection::<f64>::at(16, &[NAN]) => NotFinite,
        LowProjection::<f64>::at(16, &[INF]) => NotFinite,
        LowProjection::<f64>::at(16, &[1e300]) => Range,
        LowProjection::<f64>::at(16, &[3.0, 3.0]) => Range,
        LowProjection::<f64>::at(16, &[]) => Range,
    ]);
}

#[test]
fn sphere_and_numeric_constructors() {
    check(made![
        GaussLegendre::new(0) => Empty,
        GaussLegendre::new(GaussLegendre::MAX_POINTS + 1) => Range,
        GaussLegendre::new(HUGE) => Range,
        GaussLegendre::new(1) => Fine,
        SphereQuadrature::new(0) => Fine,
        SphereQuadrature::new(HUGE) => Range,
        CubeGrid::new(0) => Range,
        CubeGrid::new(HUGE) => Range,
        LatLongGrid::new(0, 1) => Range,
        LatLongGrid::new(1, HUGE) => Range,
        CubeMap::new(CubeGrid::new(16_384)?, vec![1.0f32]) => Length,
        LatLongMap::new(LatLongGrid::new(65536, 65536)?, vec![1.0f32]) => Length,
    ]);
}

#[test]
fn compress_constructors() {
    let pca = |components, columns| Pca::new(&[1.0f64, 2.0, 4.0, 3.0], columns, &PcaSettings::new(components));
    let clustered = |settings: ClusteredPcaSettings| ClusteredPca::new(&[1.0f64, 2.0, 4.0, 3.0], 2, &settings, &());
    let two = ClusteredPcaSettings::new(2, 1);
    let matrix = SparseMatrix::from_triplets(2, 2, 1.0, [(0, 0, 1)]).unwrap();
    check(made![
        pca(HUGE, 2) => Fine,
        pca(0, 2) => Fine,
        pca(1, 0) => Empty,
        pca(1, HUGE) => Length,
        pca(1, 3) => Length,
        Pca::new(&[1.0, 1e150], 1, &PcaSettings::new(1)) => Range,
        Pca::new(&[1.0, NAN], 1, &PcaSettings::new(1)) => NotFinite,
        Pca::new(&[TINY, 3.0 * TINY, 0.0, TINY], 2, &PcaSettings::new(2)) => Fine,
        Pca::new(&[1.0, 2.0], 1, &PcaSettings::new(1).with_oversampling(HUGE)) => Fine,
        Pca::new(&[1.0, 2.0], 1, &PcaSettings::new(1).with_power_iterations(HUGE)) => Range,
        Pca::<f64>::from_parts(vec![], vec![], vec![], 0.0) => Empty,
        Pca::from_parts(vec![1.0], vec![NAN], vec![1.0], 0.0) => NotFinite,
        clustered(ClusteredPcaSettings::new(2, HUGE)) => Range,
        clustered(ClusteredPcaSettings::new(HUGE, 1)) => Fine,
        clustered(ClusteredPcaSettings::new(HUGE, HUGE)) => Range,
        clustered(ClusteredPcaSettings::new(2, 3)) => Fine,
        clustered(ClusteredPcaSettings::new(0, 0)) => Range,
        clustered(two.with_iterations(HUGE).with_tolerance(0.0)) => Fine,
        clustered(two.with_iterations(0)) => Fine,
        clustered(two.with_tolerance(NAN)) => Range,
        clustered(two.with_tolerance(INF)) => Fine,
        QuantisedBytes::<f32>::new(&[], HUGE, ByteBlocks::Columns) => Range,
        QuantisedBytes::<f32>::new(&[], 5, ByteBlocks::Columns).map(|bytes| bytes.block(4)) => Fine,
        QuantisedBytes::<f32>::new(&[], 0, ByteBlocks::Rows) => Range,
        QuantisedBytes::new(&[1.0f32], HUGE, ByteBlocks::Columns) => Length,
        QuantisedBytes::new(&[1.0f32], 1, ByteBlocks::Runs(HUGE)) => Fine,
        QuantisedBytes::new(&[1.0f32], 1, ByteBlocks::Runs(0)) => Range,
        QuantisedBytes::new(&[MAX, -MAX], 1, ByteBlocks::Columns) => Range,
        QuantisedBytes::new(&[0.0, TINY], 1, ByteBlocks::Columns) => Fine,
        QuantisedBytes::new(&[NAN], 1, ByteBlocks::Columns) => NotFinite,
        QuantisedHalf::new(&[65520.0]) => Range,
        QuantisedHalf::new(&[INF]) => NotFinite,
        QuantisedHalf::new(&[TINY, -0.0]) => Fine,
        SparseMatrix::from_triplets(HUGE, 1, 1.0, []) => Range,
        SparseMatrix::from_triplets(0, HUGE, 1.0, []) => Range,
        SparseMatrix::from_triplets(1, 1, NAN, []) => Range,
        SparseMatrix::from_triplets(1, 1, 0.0, []) => Range,
        SparseMatrix::from_triplets(1, 1, TINY, [(0, 0, i32::MIN)]) => Range,
        SparseMatrix::from_triplets(1, 1, 1.0, [(HUGE, 0, 1)]) => Range,
        SparseMatrix::from_rows(1, 1.0, vec![], vec![], vec![]) => Empty,
        SparseMatrix::from_rows(1, 1.0, vec![0, HUGE], vec![], vec![]) => Length,
        SparseMatrix::quantise(1, 1, 1.0, [(0, 0, MAX)]) => Range,
        SparseMatrix::quantise(1, 1, TINY, [(0, 0, 1.0)]) => Range,
        SparseMatrix::quantise(1, 1, 1.0, [(0, 0, NAN)]) => NotFinite,
        Biclustering::new(&matrix, &BiclusterSettings::default().with_group_rows(0), &()) => Range,
        Biclustering::new(&matrix, &BiclusterSettings::default().with_group_rows(HUGE), &()) => Fine,
        Biclustering::with_groups(&matrix, &[u32::MAX, 0], &BiclusterSettings::default(), &()) => Fine,
        CodedBinaryMaps::<u8>::new(0) => Range,
        CodedBinaryMaps::<u8>::new(257) => Range,
        CodedBinaryMaps::<u32>::new(HUGE) => Range,
        CodedBinaryMaps::<u32>::new(1 << 32) => Fine,
        CodedGrayMaps::<u16>::new(16, 0) => Range,
        CodedGrayMaps::<u16>::with_bits(16, 0) => Range,
        CodedGrayMaps::<u16>::with_bits(16, u32::MAX) => Range,
        Scan::new(ScanOrder::Hilbert, HUGE, HUGE) => Range,
        Scan::new(ScanOrder::RowMajor, 0, HUGE) => Range,
        Scan::new(ScanOrder::Serpentine, 1 << 33, 1) => Range,
        Scan::turned(ScanOrder::Hilbert, 1, 2) => Length,
    ]);
}

/// What a call must give.
#[derive(Debug, Clone, Copy)]
enum Gives {
    Exactly(f64),
    /// Within 1e-14 of it, relative.
    About(f64),
    Nan,
    /// Any finite number.
    Finite,
}
use Gives::{About, Exactly, Finite, Nan};

type Call<'a> = (&'static str, Box<dyn Fn() -> f64 + 'a>, Gives);

macro_rules! given {
    ($($call:expr => $gives:expr),* $(,)?) => {
        vec![$((stringify!($call), Box::new(|| $call) as Box<dyn Fn() -> f64>, $gives)),*]
    };
}

#[track_caller]
fn check_values(table: Vec<Call>) {
    let mut wrong = Vec::new();
    for (text, call, want) in table {
        let Ok(got) = catch_unwind(AssertUnwindSafe(&call)) else {
            wrong.push(format!("{text}: panics"));
            continue;
        };
        let right = match want {
            Exactly(x) => got == x,
            About(x) => (got - x).abs() <= 1e-14 * x.abs(),
            Nan => got.is_nan(),
            Finite => got.is_finite(),
        };
        if !right {
            wrong.push(format!("{text}: {got:e}, want {want:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn map(s: f64, o: f64) -> AffineMap {
    AffineMap::new(s, o).unwrap()
}

/// The digits (plus one) of the targets that a prediction chooses.
fn first(heuristic: Heuristic) -> f64 {
    let prediction = Prediction::<1>::new(4, heuristic, grid(3), Keep::Terms(2)).unwrap();
    f64::from(prediction.targets([map(1.0, 0.0)]).iter().fold(0, |all, k| 10 * all + k + 1))
}

#[test]
fn affine_values() {
    let (psi, phi) = (Mother::Wavelet, Mother::Scaling);
    let table = CanonicalTable::new(64, Quantisation::F32).unwrap();
    let coarse = table.clone().with_filter(Filter::LinearFixed(u32::MAX));
    let light = |unit: f64| [4.0 * unit, unit, 2.0 * unit, 0.0];
    let ordinary = first(Heuristic::Light(&light(1.0)));
    let squares = first(Heuristic::Power(&light(1.0)));
    check_values(given![
        canonical(psi, psi, NAN, 0.5) => Nan,
        canonical(psi, psi, 0.0, 0.3) => Exactly(0.0),
        canonical(psi, psi, TINY, 0.0) => Finite,
        canonical(psi, psi, MAX, 0.5) => Exactly(1.0),
        canonical(phi, phi, MAX, 0.5) => Exactly(1.0),
        canonical(phi, phi, 1.0, MAX) => Exactly(0.0),
        canonical(psi, phi, INF, 0.5) => Exactly(0.0),
        canonical_gradient(psi, psi, MAX, MAX)[0] => Finite,
        table.lookup(0.0, 0.3) => Exactly(0.0),
        table.lookup(MAX, MAX) => Finite,
        table.lookup(MAX, 0.5) => Finite,
        table.lookup(-1e300, 1.0) => Finite,
        table.lookup(0.25, INF) => Exactly(0.0),
        table.lookup(INF, 0.0) => Nan,
        table.lookup(NAN, 0.0) => Nan,
        coarse.lookup(0.25, 0.5) => Exactly(0.5),
        coupling_1d(HUGE, HUGE, ID) => Finite,
        coupling_1d(HUGE, 0, map(1e-100, 1e100)) => Exactly(0.0),
        coupling_1d(0, HUGE, map(-1e100, 1e100)) => Finite,
        coupling_gradient_1d(HUGE, HUGE, map(1e-100, 1.0))[0] => Finite,
        tripling_1d(HUGE, HUGE, HUGE, ID) => Finite,
        coupling_1d(0, 0, map(1e-100, 0.0)) => Exactly(1.0),
        coupling_1d(0, 0, map(1e-100, -5e-101)) => About(0.5),
        coupling_1d(0, 0, map(1e100, 0.0)) => About(1e-100),
        coupling_1d(0, 0, map(-1e100, 1e100)) => About(1e-100),
        map(1e-100, 1e100).inverse().offset() => Exactly(-1e100),
        map(1e-100, -1e100).inverse().offset() => Exactly(1e100),
        map(1e100, 1e100).inverse().scale() => Exactly(1e-100),
        map(-1e-100, 0.0).inverse().scale() => About(-1e100),
        pixel_coupling(HUGE, HUGE - 1, HUGE - 1, ID) => Finite,
        pixel_coupling_bound(HUGE, ID) as f64 => Exactly(HUGE as f64),
        pixel_coupling_bound(0, ID) as f64 => Exactly(0.0),
        fourier_coupling(i64::MAX, i64::MIN, map(1e100, 1e100)).norm() => Finite,
        fourier_coupling(0, 0, map(1e-100, 1e100)).re => Exactly(1.0),
        fourier_tripling_count(0..0, ID) as f64 => Exactly(0.0),
        fourier_tripling_count(-3_000_000..3_000_000, map(0.3, 0.0)) as f64 => Exactly(u64::MAX as f64),
        Atom::from_flat(HUGE).level.into() => Exactly(63.0),
        first(Heuristic::Light(&light(1e200))) => Exactly(ordinary),
        first(Heuristic::Light(&light(1e-200))) => Exactly(ordinary),
        first(Heuristic::Light(&light(1e-320))) => Exactly(ordinary),
        first(Heuristic::Light(&light(4e307))) => Exactly(ordinary),
        first(Heuristic::Power(&light(4e307))) => Exactly(squares),
        first(Heuristic::Power(&light(1e-320))) => Exactly(squares),
    ]);
}

#[test]
fn haar_values() {
    let all = |x: f64| MeanTree::from_pixels(2, [&[x; 4][..]]).unwrap().mean(0, 0);
    let corner = [MAX, MAX, MAX, -MAX];
    let back = MeanTree::from_coefficients(2, [&forward_2d(&corner, 2, 2, NONSTANDARD).unwrap()[..]]).unwrap();
    let single = MeanTree::from_pixels(2, [&[f32::MAX; 4][..]]).unwrap().mean(0, 0);
    let masked = |x: f64, word: u64| {
        let mut texels = [1.0; 70];
        (texels[3], texels[66]) = (x, x);
        MaskedSum::new().dot(&texels, &[2.0; 70], &[word, word])
    };
    let other = |x: f64| {
        let mut weights = [2.0f32; 64];
        weights[3] = x as f32;
        MaskedSum::new().dots([&[1.0; 64], &[1.0; 64]], &weights, &[0xf7])[1]
    };
    let weight = |x: f64| {
        let row = SparseVector::from_dense(&[3.0 * x, 0.0]);
        transport_weights(2, [&row, &SparseVector::from_dense(&[4.0 * x, 0.0])]).unwrap()[0]
    };
    let single_row = SparseVector::from_dense(&[f32::MAX]);
    check_values(given![
        all(MAX) => Exactly(MAX),
        all(-MAX) => Exactly(-MAX),
        all(TINY) => Finite,
        all(NAN) => Nan,
        single.into() => Exactly(f32::MAX.into()),
        back.mean(1, 0) => About(MAX),
        back.mean(4, 0) => About(-MAX),
        Pyramid::from_pixels(2, &[MAX; 4]).unwrap().values()[0] => Exactly(MAX),
        forward_1d(&[MAX, MAX]).unwrap()[0] => Exactly(MAX),
        forward_1d(&[MAX, -MAX]).unwrap()[1] => Exactly(MAX),
        masked(NAN, !0 << 4) => Exactly(2.0 * 60.0 + 2.0 * 2.0),
        masked(INF, 0xf0) => Exactly(8.0 + 4.0),
        masked(NAN, !0) => Nan,
        masked(NAN, 0) => Exactly(0.0),
        other(NAN) => Exactly(14.0),
        other(INF) => Exactly(14.0),
        Keep::Fraction(NAN).of(10) as f64 => Exactly(0.0),
        Keep::Fraction(-1.0).of(10) as f64 => Exactly(0.0),
        Keep::Fraction(INF).of(10) as f64 => Exactly(10.0),
        Keep::Fraction(TINY).of(10) as f64 => Exactly(1.0),
        Keep::Terms(HUGE).of(0) as f64 => Exactly(0.0),
        weight(1.0) => Exactly(5.0),
        weight(1e200) => About(5e200),
        weight(1e-200) => About(5e-200),
        weight(4e307) => Exactly(MAX),
        weight(NAN) => Nan,
        transport_weights(1, [&single_row, &single_row]).unwrap()[0].into() => Exactly(f32::MAX.into()),
        haar_tripling_1d(HUGE, HUGE, 0).value::<f64>() => Exactly(1.0),
        tripling_2d(HUGE, HUGE, HUGE).value::<f64>() => Exactly(0.0),
        tripling_2d(HUGE, HUGE, 1).value::<f32>().into() => Finite,
    ]);
}

#[test]
fn table_values() {
    let edge_at = |form, x: f64, y: f64, frame| {
        let map: Vec<bool> = (0..64).map(|i| i % 8 < 4).collect();
        let table = VisibilityDistance::new([8, 8], &map[..], frame).unwrap();
        table.as_ref().coverage([x, y], 2.0, form)
    };
    let slope = |x: f64, y: f64| {
        let table = VisibilityDistance::new([8, 8], &[true; 64][..], Border::Zero).unwrap();
        table.as_ref().gradient([x, y])[0]
    };
    let diagonal = -std::f64::consts::FRAC_1_SQRT_2;
    let area: SummedArea<f64> = SummedArea::new(2, 2, &[1.0, 2.0, 3.0, 4.0]).unwrap();
    let part = |left, right| Rectangle { left, top: 0.0, right, bottom: 2.0 };
    let disk = DiskGrid::new(4).unwrap();
    let unit = half_plane_coverage(0.2, 1.0, [0.6, 0.8]);
    check_values(given![
        half_plane_coverage(0.2, 1.0, [6e299, 8e299]) => About(unit),
        half_plane_coverage(0.2, 1.0, [6e307, 8e307]) => About(unit),
        half_plane_coverage(0.2, 1.0, [MAX, MAX]) => About(half_plane_coverage(0.2, 1.0, [1.0, 1.0])),
        half_plane_coverage(0.2, 1.0, [3e-310, 4e-310]) => About(half_plane_coverage(0.2, 1.0, [3.0, 4.0])),
        half_plane_coverage(0.2, 1.0, [TINY, TINY]) => About(half_plane_coverage(0.2, 1.0, [1.0, 1.0])),
        half_plane_coverage(0.2, 1.0, [INF, 1.0]) => About(half_plane_coverage(0.2, 1.0, [1.0, 0.0])),
        half_plane_coverage(0.2, 1.0, [INF, -INF]) => About(half_plane_coverage(0.2, 1.0, [1.0, 1.0])),
        half_plane_coverage(0.2, 1.0, [NAN, 1.0]) => Nan,
        half_plane_coverage(0.2, 1.0, [INF, NAN]) => Nan,
        half_plane_coverage(NAN, 1.0, [0.6, 0.8]) => Nan,
        half_plane_coverage(1e308, 1.6e308, [0.0, 1.0]) => Exactly(1.0),
        half_plane_coverage(2e307, 1e308, [0.6, 0.8]) => About(half_plane_coverage(0.2, 1.0, [0.6, 0.8])),
        half_plane_coverage(INF, 1.0, [0.6, 0.8]) => Exactly(1.0),
        half_plane_coverage(-INF, 1.0, [0.6, 0.8]) => Exactly(0.0),
        half_plane_coverage(0.2, INF, [0.6, 0.8]) => Exactly(0.5),
        half_plane_coverage(-0.2, 0.0, [0.6, 0.8]) => Exactly(0.0),
        half_plane_coverage(0.0, -1.0, [0.6, 0.8]) => Exactly(0.5),
        half_plane_coverage(TINY, TINY, [0.6, 0.8]) => Exactly(1.0),
        mean_coverage(1.2e308, 1.7e308) => About(mean_coverage(12.0, 17.0)),
        mean_coverage(-MAX, 1.0) => Exactly(0.0),
        linear_coverage(-1.1e308, 1.7e308) => Exactly(0.0),
        linear_coverage(MAX, TINY) => Exactly(1.0),
        smoothstep_coverage(1e308, 1.7e308) => About(smoothstep_coverage(10.0, 17.0)),
        smoothstep_coverage(NAN, 1.0) => Nan,
        edge_at(Coverage::Gradient, INF, 4.0, Border::Zero) => Exactly(0.0),
        edge_at(Coverage::Gradient, -INF, INF, Border::Zero) => Exactly(0.0),
        edge_at(Coverage::Gradient, INF, 4.0, Border::Open) => Exactly(0.0),
        edge_at(Coverage::Gradient, -INF, 4.0, Border::Open) => Exactly(1.0),
        edge_at(Coverage::Gradient, MAX, MAX, Border::Zero) => Exactly(0.0),
        edge_at(Coverage::Gradient, NAN, 4.0, Border::Zero) => Nan,
        edge_at(Coverage::Gradient, INF, NAN, Border::Zero) => Nan,
        edge_at(Coverage::Mean, INF, 4.0, Border::Zero) => Exactly(0.0),
        edge_at(Coverage::Linear, 1e300, 4.0, Border::Zero) => Exactly(0.0),
        slope(INF, 4.0) => Exactly(-1.0),
        slope(INF, INF) => About(diagonal),
        slope(MAX, MAX) => About(diagonal),
        slope(1e301, -1e301) => About(diagonal),
        slope(-INF, 1e300) => Exactly(1.0),
        slope(NAN, 4.0) => Nan,
        area.sum(part(-INF, INF)) => Exactly(10.0),
        area.sum(part(-MAX, MAX)) => Exactly(10.0),
        area.sum(part(NAN, 1.0)) => Nan,
        area.sum(part(INF, -INF)) => Exactly(-10.0),
        area.mean(part(-MAX, MAX)) => Exactly(0.0),
        area.as_ref().sum_beyond(part(-1e300, 1e300), [Outside::Zero; 2]) => Exactly(10.0),
        area.as_ref().sum_beyond(part(0.0, INF), [Outside::Wrap; 2]) => Nan,
        area.as_ref().pixel([INF, 0.0]) => Exactly(0.0),
        area.as_ref().pixel([NAN, INF]) => Nan,
        f64::from(u8::from(disk.contains(HUGE, HUGE))) => Exactly(0.0),
        f64::from(u8::from(disk.contains(1 << 62, 0))) => Exactly(0.0),
        f64::from(u8::from(disk.contains(4, 1))) => Exactly(0.0),
        f64::from(u8::from(disk.contains(1, 1))) => Exactly(1.0),
    ]);
}

#[test]
fn sphere_and_numeric_values() {
    let cube = CubeMap::from_fn(CubeGrid::new(4).unwrap(), |d| 2.0 + d.x);
    let globe = LatLongMap::from_fn(LatLongGrid::new(8, 4).unwrap(), |d| 2.0 + d.x);
    let dot = LatLongMap::from_fn(LatLongGrid::new(1, 1).unwrap(), |_| 3.0);
    let at = |x, y, z| cube.bilinear(&Vector3::new(x, y, z));
    let on = |x, y, z| globe.bilinear(&Vector3::new(x, y, z));
    let disk = |x, y| HemisphereDisk::direction(&[x, y].into()).z;
    let nowhere = Rotation3::from_matrix_unchecked(Matrix3::from_element(NAN));
    let turned = |how| globe.to_cube(CubeGrid::new(16).unwrap(), &nowhere, how).texels()[7];
    let spread = |how| cube.to_lat_long(LatLongGrid::new(32, 16).unwrap(), &nowhere, how).pixels()[7];
    let sum = |terms: &[f64]| terms.iter().copied().collect::<CompensatedSum>().total();
    check_values(given![
        at(NAN, NAN, NAN) => Nan,
        at(NAN, 0.0, 0.0) => Nan,
        at(0.0, NAN, 0.0) => Nan,
        at(0.0, 0.0, NAN) => Nan,
        at(NAN, 1.0, 0.0) => Nan,
        at(1.0, NAN, 0.0) => Nan,
        at(0.0, 1.0, NAN) => Nan,
        at(INF, 1.0, 0.0) => Nan,
        at(0.0, 0.0, 0.0) => Finite,
        at(TINY, 0.0, 0.0) => Exactly(at(1.0, 0.0, 0.0)),
        at(MAX, MAX / 2.0, 0.0) => Exactly(at(1.0, 0.5, 0.0)),
        cube.nearest(&Vector3::new(NAN, 1.0, NAN)) => Finite,
        cube.nearest(&Vector3::new(INF, -INF, 0.0)) => Finite,
        Face::locate(&Vector3::new(0.0, NAN, 0.0)).1 => Nan,
        on(NAN, 1.0, 0.0) => Nan,
        on(0.0, NAN, 0.0) => Nan,
        on(0.0, 0.0, NAN) => Nan,
        on(NAN, 0.0, INF) => Nan,
        on(0.0, 0.0, 0.0) => Finite,
        on(TINY, 0.0, 0.0) => Exactly(on(1.0, 0.0, 0.0)),
        on(MAX, -MAX, 0.0) => About(on(1.0, -1.0, 0.0)),
        dot.bilinear(&Vector3::new(0.0, -1.0, 0.0)) => Exactly(3.0),
        globe.nearest(&Vector3::new(NAN, NAN, NAN)) => Finite,
        LatLongGrid::point(NAN, 0.5).x => Nan,
        LatLongGrid::point(1e300, -1e300).x => Finite,
        LatLongGrid::point(MAX, 0.0).x => Nan,
        disk(0.0, 0.0) => Exactly(1.0),
        disk(MAX, MAX) => Exactly(-1.0),
        disk(INF, 0.0) => Exactly(-1.0),
        disk(NAN, 0.0) => Nan,
        disk(TINY, TINY) => Exactly(1.0),
        turned(Resampling::Area) => Nan,
        turned(Resampling::Smooth) => Nan,
        turned(Resampling::Bilinear) => Nan,
        spread(Resampling::Area) => Nan,
        spread(Resampling::Smooth) => Nan,
        fibonacci_directions(0).len() as f64 => Exactly(0.0),
        fibonacci_directions(1)[0].z => Exactly(0.0),
        legendre(0, NAN) => Exactly(1.0),
        legendre(1, NAN) => Nan,
        legendre(3, TINY) => Finite,
        legendre(1000, -1.0) => Exactly(1.0),
        safe_sqrt(-MAX) => Exactly(0.0),
        safe_acos(INF) => Exactly(0.0),
        safe_asin(NAN) => Nan,
        GaussLegendre::new(2).unwrap().integrate(-MAX, MAX, |x| f64::from(u8::from(x.is_finite())) / MAX) => About(2.0),
        GaussLegendre::new(2).unwrap().integrate(MAX, MAX, |x| x / MAX) => Exactly(0.0),
        sum(&[MAX, -MAX, TINY]) => Exactly(TINY),
        sum(&[INF, 1.0]) => Exactly(INF),
        sum(&[NAN]) => Nan,
    ]);
}

#[test]
fn compress_values() {
    let lost = |unit: f64| Distortion::between(&[3.0 * unit, 4.0 * unit], &[0.0, 4.0 * unit]);
    let mixed = |unit: f64| Distortion::between(&[3.0, 4.0], &[3.0 + unit, 4.0]);
    let single = Distortion::between(&[f32::MAX, 0.0], &[-f32::MAX, 0.0]);
    let clusters = |unit: f64| {
        let rows: Vec<f64> = (0..40).map(|i| unit * f64::from(10 * (i / 20) + i % 3)).collect();
        let coded = ClusteredPca::new(&rows, 1, &ClusteredPcaSettings::new(2, 0), &()).unwrap();
        coded.clusters() as f64 + coded.stats().distortion.relative
    };
    let bytes = |x: f64| {
        let coded = QuantisedBytes::new(&[0.0, x], 1, ByteBlocks::Columns).unwrap();
        let mut out = [NAN; 2];
        coded.decode(&mut out);
        out[1]
    };
    check_values(given![
        lost(1.0).relative => Exactly(0.6),
        lost(1e200).relative => About(0.6),
        lost(1e-200).relative => About(0.6),
        lost(1e300).rms => About(3e300 / 2f64.sqrt()),
        lost(1e-300).rms => About(3e-300 / 2f64.sqrt()),
        lost(1e200).max => Exactly(3.0 * 1e200),
        lost(0.0).relative => Exactly(0.0),
        lost(NAN).rms => Nan,
        mixed(1e-200).relative => Exactly(0.0),
        mixed(1e200).relative => About(2e199),
        Distortion::between(&[0.0, 0.0], &[1e-200, 0.0]).relative => Exactly(INF),
        Distortion::between(&[1e-200, 0.0], &[0.0, 0.0]).relative => Exactly(1.0),
        Distortion::between(&[MAX], &[-MAX]).max => Exactly(INF),
        Distortion::between::<f64>(&[], &[]).rms => Exactly(0.0),
        single.relative => About(2.0),
        clusters(1e-200) => About(clusters(1.0)),
        clusters(1e-300) => About(clusters(1.0)),
        clusters(1e130) => About(clusters(1.0)),
        bytes(TINY) => Finite,
        bytes(MAX / 2.0) => About(MAX / 2.0),
        bytes(1e-310) => Finite,
        f64::from(real_to_half(MAX)) => Exactly(f64::from(0x7c00)),
        f64::from(real_to_half(-TINY)) => Exactly(f64::from(0x8000)),
        half_to_real(real_to_half(NAN)) => Nan,
        half_to_real(u16::MAX) => Nan,
    ]);
}

/// A name, a call that is documented to panic, and what it says.
type Panic<'a> = (&'static str, Box<dyn Fn() + 'a>, &'static str);

#[test]
fn calls_beyond_the_size_panic_and_say_so() {
    let deep = Atom { level: 64, ..Atom::from_flat(1) };
    let matrix = SparseMatrix::from_triplets(2, 2, 1.0, [(0, 0, 1)]).unwrap();
    let clusters = Biclustering::new(&matrix, &BiclusterSettings::default(), &()).unwrap();
    let coded = ClusteredPca::new(&[1.0, 2.0], 1, &ClusteredPcaSettings::new(1, 1), &()).unwrap();
    let calls: Vec<Panic> = vec![
        ("row past the last", Box::new(|| _ = LatLongGrid::new(8, 4).unwrap().solid_angle(4)), "row 4 of 4"),
        ("last row", Box::new(|| _ = LatLongGrid::new(8, 4).unwrap().solid_angle(HUGE)), "of 4"),
        ("texel", Box::new(|| _ = CubeGrid::new(4).unwrap().solid_angle(0, 4)), "texel (0, 4)"),
        ("last texel", Box::new(|| _ = CubeGrid::new(4).unwrap().solid_angle(HUGE, 0)), "of side 4"),
        ("direction", Box::new(|| _ = LatLongGrid::new(8, 4).unwrap().direction(32)), "pixel 32 of 32"),
        ("map of a grid", Box::new(|| _ = grid(4).map(4, 0)), "outside the grid"),
        ("level", Box::new(|| _ = coupling(deep, Atom::from_flat(1), ID)), "level 64 of an atom"),
        ("level of a target", Box::new(|| _ = coupling_gradient(Atom::from_flat(0), deep, ID)), "at most 63"),
        ("level of a factor", Box::new(|| _ = tripling(Atom::from_flat(0), deep, deep, ID)), "at most 63"),
        ("pixel", Box::new(|| _ = pixel_coupling(4, 4, 0, ID)), "of 4"),
        ("sides", Box::new(|| matrix.multiply_batch(HUGE, &[1.0], &mut [0.0])), "right-hand sides"),
        (
            "sides of biclusters",
            Box::new(|| clusters.multiplier().multiply_batch(1 << 45, &[1.0], &mut [0.0], &mut [])),
            "right-hand",
        ),
        (
            "sides of clusters",
            Box::new(|| coded.multiply_batch(1 << 45, &[1.0], &mut [0.0], &mut [])),
            "right-hand sides",
        ),
    ];
    for (name, call, says) in calls {
        let panic = catch_unwind(AssertUnwindSafe(call)).expect_err(name);
        let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        let text = text.unwrap_or_default();
        assert!(text.contains(says), "{name}: {text}");
    }
}
