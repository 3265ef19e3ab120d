//! Files: what was saved is loaded, and what is damaged is refused.

use haarmonic::backend::near_field::{BakeSettings, Precision, Relighter, Settings, Transport, ViewFactors};
use haarmonic::nalgebra::Vector3;
use haarmonic::scene::{Materials, Mesh, Occluders, View};
use haarmonic::store::{Kind, Stored};

use super::{bake, lamp, materials, model};

/// Small transports of every form: of a tetrahedron, two of whose corners shine.
fn transports() -> Vec<Transport> {
    let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]].map(Vector3::from);
    let mesh = Mesh::new(corners.to_vec(), vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]).unwrap();
    let view = View::eye(Vector3::new(4.0, 3.0, 5.0)).unwrap();
    let small = BakeSettings { cells: 4, samples: 1, tolerance: 0.1, ..BakeSettings::default() };
    let shared = [false, true].map(|mixed| materials(&model(), mixed));
    let [glossy, mixed] = shared.map(|m| Materials::new(m.brdfs().to_vec(), vec![0, 0, 1, 1]).unwrap());
    let factors = ViewFactors { cells: 2, terms: 2 };
    vec![
        bake(&mesh, &view, &glossy, small),
        bake(&mesh, &view, &mixed, BakeSettings { precision: Precision::Full, ..small }),
        Transport::bake_view_free(&mesh, Occluders::of_mesh(&mesh), &glossy, factors, small, &()).unwrap(),
    ]
}

#[test]
fn transports_survive_a_file() {
    let folder = tempfile::tempdir().unwrap();
    for transport in transports() {
        let path = folder.path().join("transport");
        transport.save(&path).unwrap();
        assert_eq!(Kind::of(&path), Ok(Kind::NearField));
        assert_eq!(Transport::load(&path).unwrap(), transport);
    }
}

#[test]
fn damaged_files_are_refused() {
    for transport in transports() {
        let mut good = Vec::new();
        transport.write_to(&mut good).unwrap();
        for len in (0..good.len()).step_by(97) {
            assert!(Transport::read_from(&good[..len]).is_err(), "cut at {len}");
        }
        for bit in (0..8 * good.len()).step_by(1009) {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            assert!(Transport::read_from(&bad[..]).is_err(), "bit {bit}");
        }
    }
}

/// A byte changed and the checksum mended: whatever it means, it is refused or harmless.
#[test]
fn files_that_contradict_themselves_do_not_panic() {
    for transport in transports() {
        let mut good = Vec::new();
        transport.write_to(&mut good).unwrap();
        let end = good.len() - 4;
        let mut refused = 0;
        for at in (18..end).step_by(13) {
            for value in [0, 1, 0x7f, 0xff] {
                let mut bad = good.clone();
                bad[at] = value;
                let crc = crc32fast::hash(&bad[..end]);
                bad[end..].copy_from_slice(&crc.to_le_bytes());
                match Transport::read_from(&bad[..]) {
                    Err(error) => {
                        refused += 1;
                        assert!(error.to_string().starts_with("stream, byte "), "{error}");
                    }
                    Ok(read) => {
                        let settings = Settings { source_side: 4, ..Settings::default() };
                        let mut relighter = Relighter::new(&read, settings).unwrap();
                        relighter.set_lights(&[lamp(4, 1)]).unwrap();
                        relighter.relight(&mut vec![Vector3::zeros(); read.vertices()]);
                    }
                }
            }
        }
        assert!(refused > 40, "{refused}");
    }
}
