#![allow(warnings)]
mod transfer;
use haarmonic::compress::*;
use haarmonic::scene::*;
use std::time::Instant;
static LAST: std::sync::atomic::AtomicU64 = std::sync::atomic::AtomicU64::new(0);
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let mesh = if a[1].contains('/') { haarmonic::io::load_mesh(&a[1]).unwrap().value } else { Procedural::TorusKnotOnFloor.build(a[1].parse().unwrap()).unwrap().mesh };
    let t = Instant::now();
    let m = transfer::transfer_matrix(&mesh, &()).unwrap();
    println!("vertices {} rows {} nnz {} {:?}", mesh.positions().len(), m.rows(), m.nnz(), t.elapsed());
    let ticks = std::fs::read_to_string("/proc/self/stat").unwrap().split(' ').nth(13).unwrap().parse::<u64>().unwrap(); LAST.store(ticks, std::sync::atomic::Ordering::Relaxed);
    let show = |name: &str, b: &Biclustering, t: Instant| {
        let e = t.elapsed();
        let cpu: f64 = std::fs::read_to_string("/proc/self/stat").unwrap().split(' ').nth(13).unwrap().parse::<f64>().unwrap()/100.0;
        let last = LAST.swap((cpu*100.0) as u64, std::sync::atomic::Ordering::Relaxed) as f64/100.0;
        print!("cpu {:.2} ", cpu - last);
        let s = b.stats();
        println!("{name}: {e:?} flops {:.4} bytes {:.4} n {} r {} l {}", s.flops as f64 / s.matrix_flops as f64, s.bytes as f64 / s.matrix_bytes as f64, s.biclusters, s.row_entries, s.column_entries);
    };
    for g in [1024, 2048, 4096, 8192, 16384] {
        let set = BiclusterSettings::default().with_group_rows(g);
        let t = Instant::now();
        let b = Biclustering::new(&m, &set, &()).unwrap();
        show(&format!("shared {g}"), &b, t);
    }
    // by mean column direction cell
    let grid = haarmonic::sphere::CubeGrid::new(32).unwrap();
    let dirs = grid.directions();
    for cells in [4usize] {
        let coarse = haarmonic::sphere::CubeGrid::new(cells).unwrap();
        let groups: Vec<u32> = (0..m.rows()).map(|j| {
            let mut s = haarmonic::nalgebra::Vector3::zeros();
            for &c in m.row(j).0 { s += dirs[c as usize].into_inner(); }
            if s.norm() == 0.0 { return 0 }
            coarse.nearest(&s) as u32
        }).collect();
        let t = Instant::now();
        let b = Biclustering::with_groups(&m, &groups, &BiclusterSettings::default(), &()).unwrap();
        show(&format!("cells {cells}"), &b, t);
    }
}
