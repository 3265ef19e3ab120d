//! The file form of what compression gives: saved and loaded it is the same, damaged it is refused.

use std::fmt::Debug;

use haarmonic::Error;
use haarmonic::compress::{
    Bicluster, BiclusterSettings, Biclustering, ByteBlocks, ClusteredPca, ClusteredPcaSettings, CodedBinaryMaps,
    CodedGrayMaps, Distortion, Pca, PcaSettings, QuantisedBytes, QuantisedHalf, SparseMatrix,
};
use haarmonic::store::{Kind, Stored};

use crate::support::random;

fn bytes_of(stored: &impl Stored) -> Vec<u8> {
    let mut bytes = Vec::new();
    stored.write_to(&mut bytes).unwrap();
    bytes
}

/// Round trip, every cut, every flipped bit; and every bit that is flipped under a good checksum gives an error or
/// something that can be stored itself.
fn keeps<S: Stored + PartialEq + Debug>(stored: &S, kind: Kind) {
    assert_eq!(S::kind(), kind);
    let good = bytes_of(stored);
    assert_eq!(&S::read_from(&good[..]).unwrap(), stored);
    assert!(good.len() < 4000, "{} bytes: too many to try every bit", good.len());
    for cut in 0..good.len() {
        assert!(matches!(S::read_from(&good[..cut]), Err(Error::File { .. })), "cut at {cut}");
    }
    let mut sound = 0;
    for bit in 0..8 * good.len() {
        let mut bad = good.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        assert!(matches!(S::read_from(&bad[..]), Err(Error::File { .. })), "bit {bit}");
        let end = bad.len() - 4;
        let crc = crc32(&bad[..end]);
        bad[end..].copy_from_slice(&crc.to_le_bytes());
        match S::read_from(&bad[..]) {
            Ok(other) => {
                sound += 1;
                assert_eq!(bytes_of(&other).len(), good.len(), "bit {bit}");
            }
            Err(error) => assert!(matches!(error, Error::File { .. }), "bit {bit}: {error}"),
        }
    }
    assert!(sound > 0, "some bits are those of numbers");
}

/// CRC-32 bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 })
    })
}

#[test]
fn maps() {
    let mut binary = CodedBinaryMaps::<u8>::new(100).unwrap();
    let mut wide = CodedBinaryMaps::<u16>::new(300).unwrap();
    let mut gray = CodedGrayMaps::<u8>::new(64, 15).unwrap();
    for (k, numbers) in random(5 * 300, 5).chunks(300).enumerate() {
        let bits: Vec<bool> = numbers.iter().map(|x| x.abs() < 0.2 * k as f64).collect();
        binary.push_bools(&bits[..100]);
        wide.push_bools(&bits);
        gray.push_levels(&numbers[..64].iter().map(|x| (x.abs() * 15.9) as u8 / 4 * 4).collect::<Vec<_>>());
    }
    keeps(&binary, Kind::CodedBinaryMaps);
    keeps(&wide, Kind::CodedBinaryMaps);
    keeps(&gray, Kind::CodedGrayMaps);
    keeps(&CodedBinaryMaps::<u8>::new(1).unwrap(), Kind::CodedBinaryMaps);
    // Maps of 16-bit places are not those of 8 bits.
    assert!(CodedBinaryMaps::<u8>::read_from(&bytes_of(&wide)[..]).is_err());
    assert!(
        CodedGrayMaps::<u8>::read_from(&bytes_of(&binary)[..]).unwrap_err().to_string().contains("expected gray maps")
    );
}

#[test]
fn many_maps_take_several_sections() {
    let mut maps = CodedBinaryMaps::<u8>::new(8).unwrap();
    (0..150_000_u32).for_each(|k| maps.push_bits(&[u64::from(k % 251)]));
    assert_eq!(CodedBinaryMaps::read_from(&bytes_of(&maps)[..]), Ok(maps));
}

#[test]
fn components() {
    let matrix = random(12 * 5, 5);
    let pca = Pca::new(&matrix, 5, &PcaSettings::new(2)).unwrap();
    keeps(&pca, Kind::Pca);
    let narrow: Vec<f32> = matrix.iter().map(|&x| x as f32).collect();
    let pca32 = Pca::new(&narrow, 5, &PcaSettings::new(2)).unwrap();
    keeps(&pca32, Kind::Pca);
    let error = Pca::<f64>::read_from(&bytes_of(&pca32)[..]).unwrap_err().to_string();
    assert!(error.ends_with("holds numbers of 32 bits, expected 64"), "{error}");
    let clustered = ClusteredPca::new(&narrow, 5, &ClusteredPcaSettings::new(3, 1), &()).unwrap();
    keeps(&clustered, Kind::ClusteredPca);
    keeps(&ClusteredPca::new(&matrix, 5, &ClusteredPcaSettings::new(2, 0), &()).unwrap(), Kind::ClusteredPca);
}

#[test]
fn quantised_numbers() {
    let values = random(23 * 2, 5);
    keeps(&QuantisedHalf::new(&values).unwrap(), Kind::QuantisedHalf);
    keeps(&QuantisedHalf::new::<f32>(&[]).unwrap(), Kind::QuantisedHalf);
    for blocks in [ByteBlocks::Rows, ByteBlocks::Columns, ByteBlocks::Runs(7)] {
        keeps(&QuantisedBytes::new(&values, 2, blocks).unwrap(), Kind::QuantisedBytes);
    }
}

#[test]
fn biclusters() {
    let triplets = (0..8).flat_map(|j| (0..6).map(move |k| (j, k, [0, 3, 3, -1, 2][(j * k + j / 3) % 5])));
    let matrix = SparseMatrix::from_triplets(8, 6, 0.25, triplets).unwrap();
    let biclusters = Biclustering::new(&matrix, &BiclusterSettings::default(), &()).unwrap();
    keeps(&biclusters, Kind::Biclustering);
    let again = Biclustering::from_parts(8, 6, 0.25, biclusters.iter()).unwrap();
    assert_eq!((again.to_matrix(), again.stats()), (matrix, biclusters.stats()));
}

#[test]
fn parts_that_do_not_fit_are_refused() {
    let of = |rows: &'static [u32], columns: &'static [u32], levels: &'static [i32]| {
        Biclustering::from_parts(3, 4, 1.0, [Bicluster { rows, columns, levels }])
    };
    assert_eq!(of(&[0, 2], &[1, 3], &[5, -1]).unwrap().to_matrix().nnz(), 4);
    assert!(matches!(of(&[3], &[1], &[5]), Err(Error::Index { got: 3, count: 3, .. })));
    assert!(matches!(of(&[0], &[4], &[5]), Err(Error::Index { got: 4, count: 4, .. })));
    assert!(matches!(of(&[0], &[1], &[]), Err(Error::Length { .. })));
    for (rows, columns, levels) in [(&[][..], &[1][..], &[1][..]), (&[1, 1], &[1], &[1]), (&[0], &[2, 1], &[1, 1])] {
        assert!(matches!(of(rows, columns, levels), Err(Error::Damaged { .. })), "{rows:?} {columns:?}");
    }
    assert!(matches!(of(&[0], &[1], &[0]), Err(Error::Damaged { .. })));
    let top = SparseMatrix::MAX_LEVEL;
    let twice = [top, 1].map(|level| [level]);
    let both = twice.each_ref().map(|levels| Bicluster { rows: &[0], columns: &[1], levels });
    assert!(matches!(Biclustering::from_parts(3, 4, 1.0, both), Err(Error::OutOfRange { .. })));
    assert!(Biclustering::from_parts(1 << 31, 4, 1.0, []).is_err());
    // 2^18 × 2^18 elements, twice.
    let all: Vec<u32> = (0..1 << 18).collect();
    let levels = vec![1; all.len()];
    let large = [(); 2].map(|()| Bicluster { rows: &all, columns: &all, levels: &levels });
    assert!(matches!(Biclustering::from_parts(1 << 18, 1 << 18, 1.0, large), Err(Error::OutOfRange { .. })));

    let nothing = Distortion::default();
    let pca = |columns, components, bases: usize, labels: &[u32], weights: usize| {
        let labels = labels.to_vec();
        ClusteredPca::from_parts(columns, components, vec![1.0; bases], labels, vec![0.5; weights], nothing)
    };
    assert_eq!(pca(3, 1, 12, &[0, 1, 1], 3).unwrap().clusters(), 2);
    assert!(matches!(pca(0, 1, 12, &[0], 1), Err(Error::Empty { .. })));
    assert!(matches!(pca(3, 1, 12, &[], 0), Err(Error::Empty { .. })));
    assert!(matches!(pca(3, 1, 11, &[0], 1), Err(Error::Length { .. })));
    assert!(matches!(pca(usize::MAX, usize::MAX, 11, &[0], 1), Err(Error::Length { .. })));
    assert!(matches!(pca(3, 1, 12, &[0], 2), Err(Error::Length { .. })));
    assert!(matches!(pca(3, 1, 12, &[2], 1), Err(Error::Index { got: 2, count: 2, .. })));
    let nan = ClusteredPca::from_parts(1, 0, vec![f32::NAN], vec![0], vec![], nothing);
    assert!(matches!(nan, Err(Error::NotFinite { .. })));

    assert!(matches!(QuantisedHalf::from_parts(vec![0x3c00, 0x7c00], nothing), Err(Error::NotFinite { index: 1, .. })));
    let bytes = |offsets: Vec<f32>, steps: Vec<f32>| {
        QuantisedBytes::from_parts(vec![1, 2, 3, 255], 2, ByteBlocks::Rows, offsets, steps, nothing)
    };
    let mut out = [0.0; 4];
    bytes(vec![0.0, 1.0], vec![1.0, 0.5]).unwrap().decode(&mut out);
    assert_eq!(out, [1.0, 2.0, 2.5, 128.5]);
    assert!(matches!(bytes(vec![0.0], vec![1.0, 0.5]), Err(Error::Length { .. })));
    assert!(matches!(bytes(vec![0.0; 2], vec![1.0, -0.5]), Err(Error::OutOfRange { .. })));
    assert!(matches!(bytes(vec![0.0, f32::MAX], vec![1.0, f32::MAX]), Err(Error::NotFinite { index: 1, .. })));
    assert!(matches!(bytes(vec![0.0, f32::NAN], vec![1.0, 0.0]), Err(Error::NotFinite { index: 1, .. })));

    // Found by fuzzing: what has NaN is not what is loaded.
    for bad in [f64::NAN, -0.5] {
        let mut wrong = Distortion::default();
        wrong.rms = bad;
        let refused = [
            ClusteredPca::from_parts(1, 0, vec![1.0], vec![0], vec![], wrong).err(),
            QuantisedHalf::from_parts(vec![0x3c00], wrong).err(),
            QuantisedBytes::from_parts(vec![1], 1, ByteBlocks::Rows, vec![0.0], vec![1.0], wrong).err(),
        ];
        assert!(refused.iter().all(|e| matches!(e, Some(Error::OutOfRange { what: "distortion", .. }))), "{refused:?}");
    }
}
