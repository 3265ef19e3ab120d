//! Affine couplings and the enumeration of the non-zero ones.
use haarmonic::affine::{AffineMap, Nonzeros1d, NonzerosNonstandard, coupling_1d};
#[test]
fn counts() {
    for n in [8, 16, 32, 64, 128, 256, 512, 1024] {
        let nz = Nonzeros1d::new(n).unwrap();
        let mut best = (0, 0.0, 0.0);
        let mut x = 0.1f64;
        for _ in 0..200 {
            x = (x * 997.13).fract();
            let s = 0.9 + 0.2 * x;
            x = (x * 997.13).fract();
            let o = 0.2 * x - 0.1;
            let c = nz.count(AffineMap::new(s, o).unwrap());
            if c > best.0 {
                best = (c, s, o);
            }
        }
        println!("{n} {best:?}");
    }
    let m = AffineMap::new(1.0037, -0.0021).unwrap();
    println!("{}", NonzerosNonstandard::new(32).unwrap().count([m, m]));
    let nz = Nonzeros1d::new(32).unwrap();
    println!("{}", nz.count(m).pow(2));
    let m = AffineMap::new(-0.7137, 0.9071).unwrap();
    let mut d = vec![0.0; 1024];
    nz.all(m, |i, j, v| d[i * 32 + j] = v);
    let mut c = vec![0.0; 1024];
    for j in 0..32 {
        nz.column(j, m, |i, v| c[i * 32 + j] = v);
    }
    for i in 0..32 {
        for j in 0..32 {
            assert!(
                (d[i * 32 + j] - coupling_1d(i, j, m)).abs() < 1e-14,
                "{i} {j} {} {}",
                d[i * 32 + j],
                coupling_1d(i, j, m)
            );
            assert!((d[i * 32 + j] - c[i * 32 + j]).abs() < 1e-14);
            assert_eq!(d[i * 32 + j] == 0.0, c[i * 32 + j] == 0.0);
        }
    }
}
