//! Distances to the boundary of a binary map.

/// ±(2d)², + where the map is 1: d is the distance from the centre of a pixel to the closed unit square of the nearest
/// unlike one, by looking at them all. `None` without one. With `zeros_outside` a ring of zeros surrounds the map.
pub fn signed_squares(width: usize, height: usize, map: &[bool], zeros_outside: bool) -> Vec<Option<i64>> {
    let ring = i64::from(zeros_outside);
    let (w, h) = (width as i64, height as i64);
    let value = |x: i64, y: i64| (0..w).contains(&x) && (0..h).contains(&y) && map[(y * w + x) as usize];
    // From a centre to the near side of a pixel k away, twice.
    let gap = |k: i64| (2 * k.abs() - 1).max(0);
    let signed = |x: i64, y: i64| {
        let unlike = (-ring..h + ring)
            .flat_map(|v| (-ring..w + ring).map(move |u| (u, v)))
            .filter(|&(u, v)| value(u, v) != value(x, y));
        let square = unlike.map(|(u, v)| gap(u - x).pow(2) + gap(v - y).pow(2)).min();
        square.map(|square| if value(x, y) { square } else { -square })
    };
    (0..w * h).map(|i| signed(i % w, i / w)).collect()
}
