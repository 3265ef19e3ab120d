use std::path::Path;

use super::parts::Parts;
use super::{Kind, Reader, Stored, Writer, file_error};
use crate::{Error, Result};

#[derive(Debug, PartialEq, Default)]
struct Sample {
    floats: Vec<f32>,
    number: u64,
    shorts: Vec<u16>,
}

impl Parts for Sample {
    const KIND: Kind = Kind::Pca;
    fn write(&self, to: &mut Writer) -> Result<()> {
        to.section(*b"HEAD", |s| {
            s.field(self.number);
            s.list(&self.floats);
        })?;
        to.section(*b"note", |s| s.array(b"what a later version has to say"))?;
        to.section(*b"REST", |s| s.array(&self.shorts))
    }
    fn read(from: &mut Reader) -> Result<Self> {
        let mut head = from.section(*b"HEAD")?;
        let (number, floats) = (head.field("a number")?, head.list("floats")?);
        head.end()?;
        let shorts = from.section(*b"REST")?.rest("shorts")?;
        Ok(Self { floats, number, shorts })
    }
}

fn sample() -> (Sample, Vec<u8>) {
    let sample = Sample { floats: vec![1.5, -2.0, f32::MAX], number: 7, shorts: vec![1, 2, 65535] };
    let mut bytes = Vec::new();
    sample.write_to(&mut bytes).unwrap();
    (sample, bytes)
}

#[test]
fn what_was_written_is_read() {
    let (sample, bytes) = sample();
    assert_eq!(Sample::read_from(&bytes[..]).unwrap(), sample);
    let mut bytes = Vec::new();
    Sample::default().write_to(&mut bytes).unwrap();
    assert_eq!(Sample::read_from(&bytes[..]).unwrap(), Sample::default());
}

#[test]
fn every_cut_every_flipped_bit_and_every_tail_is_refused() {
    let (_, good) = sample();
    for len in 0..good.len() {
        assert!(Sample::read_from(&good[..len]).is_err(), "cut at {len}");
    }
    for bit in 0..8 * good.len() {
        let mut bad = good.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        assert!(Sample::read_from(&bad[..]).is_err(), "bit {bit}");
    }
    assert!(Sample::read_from(&[&good[..], &[0]].concat()[..]).is_err());
}

#[test]
fn messages_say_what_is_wrong() {
    let say = |bytes: &[u8]| Sample::read_from(bytes).unwrap_err().to_string();
    assert_eq!(say(b"something else"), "stream, byte 0: is no file of haarmonic");
    let (_, good) = sample();
    let mut other = good.clone();
    other[10..14].copy_from_slice(b"DIFF");
    assert_eq!(say(&other), "stream, byte 10: holds something of kind \"DIFF\", expected principal components");
    other[10..14].copy_from_slice(b"BICL");
    assert_eq!(say(&other), "stream, byte 10: holds a biclustering, expected principal components");
    let mut newer = good.clone();
    newer[14] = 9;
    assert_eq!(say(&newer), "stream, byte 14: has version 9, this build reads version 1: make it again");
    let mut renamed = good.clone();
    renamed[18..22].copy_from_slice(b"TAIL");
    assert_eq!(say(&renamed), "stream, byte 30: a section \"HEAD\" was expected, there is one \"TAIL\"");
    // A section that claims more than there is does not take the memory.
    let mut long = good.clone();
    long[22..30].copy_from_slice(&u64::MAX.to_le_bytes());
    assert_eq!(say(&long), format!("stream, byte {}: is cut short", 30));
    let mut list = good;
    list[38..46].copy_from_slice(&(u64::MAX / 2).to_le_bytes());
    assert_eq!(say(&list), "stream, byte 46: the section ends within floats");
}

#[test]
fn a_failed_save_leaves_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sample");
    sample().0.save(&path).unwrap();
    assert_eq!(Kind::of(&path), Ok(Kind::Pca));
    let failed = super::writer::replace(&path, |_| Err(file_error(&path, "", "no room".into())));
    assert!(matches!(failed, Err(Error::File { .. })));
    assert_eq!(Sample::load(&path).unwrap(), sample().0);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "the part is gone");
    let nowhere = folder.path().join("no/such/folder");
    assert!(matches!(sample().0.save(&nowhere), Err(Error::File { .. })));
    assert!(Sample::load(&nowhere).unwrap_err().to_string().contains("cannot be opened"));
    std::fs::write(&path, "short").unwrap();
    assert!(Kind::of(&path).unwrap_err().to_string().contains("is no file of haarmonic"));
    assert!(Kind::of(Path::new("absent")).is_err());
}

#[test]
fn every_kind_has_a_tag_of_its_own() {
    for (i, kind) in Kind::ALL.iter().enumerate() {
        assert_eq!(Kind::from_tag(kind.tag()), Some(*kind));
        assert!(kind.tag().iter().all(|c| c.is_ascii_uppercase() || *c == b' '));
        assert!(Kind::ALL[..i].iter().all(|other| other.name() != kind.name()));
    }
}
