//! Spherical harmonics of a few bands at one direction, in straight lines.
//!
//! y_{l,±m} = q_{l,m}(z) {Re, Im} (x + iy)^m. The recurrence of `src/sh/basis/kernel.rs` makes of q_{m+1}, q_{m+2},
//! q_{m+3} at fixed m a multiple of z, of z² less a constant, and of z times such; from q_{m+4} on it is used as it is:
//! polynomials lose digits then.

use crate::output::Output;
use crate::text::Text;

/// The most bands.
const MOST: usize = 8;

/// q_{m,m}, and a, b of q_{l,m} = a z q_{l−1,m} − b q_{l−2,m} at [l].
struct Column {
    diagonal: f64,
    steps: Vec<[f64; 2]>,
}

impl Column {
    fn new(m: usize) -> Self {
        // (2m+1)!!/(2m)!! / 4π, twice that for m > 0.
        let square = (1..=m).map(|k| 1.0 + 0.5 / k as f64).product::<f64>() / (4.0 * std::f64::consts::PI);
        let diagonal = if m == 0 { square.sqrt() } else { (2.0 * square).sqrt() };
        let step = |l: usize| {
            let (m, l) = (m as f64, l as f64);
            let below = (l - m) * (l + m);
            let a = (2.0 * l - 1.0) * (2.0 * l + 1.0) / below;
            let b = (l - 1.0 - m) * (l - 1.0 + m) * (2.0 * l + 1.0) / (below * (2.0 * l - 3.0));
            [a.sqrt(), b.max(0.0).sqrt()]
        };
        Self { diagonal, steps: (0..MOST).map(|l| if l > m { step(l) } else { [0.0; 2] }).collect() }
    }

    /// q_{l,m}.
    fn polynomial(&self, text: &mut Text, l: usize, m: usize) -> String {
        let [a, b] = [0, 1].map(|which| move |l: usize| self.steps[l][which]);
        match l - m {
            0 => constant(self.diagonal),
            1 => text.times(&constant(a(l) * self.diagonal), "z"),
            2 => {
                text.additions += 1;
                let square = text.times(&constant(a(l) * a(l - 1) * self.diagonal), "square");
                format!("{square} - {}", constant(b(l) * self.diagonal))
            }
            3 => {
                text.additions += 1;
                let square = text.times(&constant(a(l) * a(l - 1) * a(l - 2) * self.diagonal), "square");
                let less = (a(l) * b(l - 1) + b(l) * a(l - 2)) * self.diagonal;
                text.times("z", &format!("({square} - {})", constant(less)))
            }
            _ => {
                text.additions += 1;
                let up = text.times(&constant(a(l)), "z");
                let up = text.times(&format!("({up})"), &format!("q{}", l - 1));
                format!("{up} - {}", text.times(&constant(b(l)), &format!("q{}", l - 2)))
            }
        }
    }
}

fn constant(value: f64) -> String {
    format!("T::of({value:?})")
}

/// The body of the function of `bands` bands.
fn body(bands: usize) -> Text {
    let mut text = Text::default();
    if bands > 2 {
        let square = text.times("z", "z");
        text.set("square", &square);
    }
    for m in 0..bands {
        match m {
            0 => {}
            1 => text.line("let (c, s) = (x, y);"),
            _ => {
                let [xc, ys] = [["x", "c"], ["y", "s"]].map(|[a, b]| text.times(a, b));
                let [xs, yc] = [["x", "s"], ["y", "c"]].map(|[a, b]| text.times(a, b));
                text.additions += 2;
                text.line(&format!("let (c, s) = ({xc} - {ys}, {xs} + {yc});"));
            }
        }
        let column = Column::new(m);
        for l in m..bands {
            let (centre, q) = (l * (l + 1), column.polynomial(&mut text, l, m));
            text.set(&format!("q{l}"), &q);
            if m == 0 {
                text.line(&format!("out[{centre}] = q{l};"));
                continue;
            }
            for (part, at) in [("c", centre + m), ("s", centre - m)] {
                let value = text.times(&format!("q{l}"), part);
                text.line(&format!("out[{at}] = {value};"));
            }
        }
    }
    text
}

/// The file.
pub(crate) fn output() -> Output {
    let mut text = String::from(
        "//! All y of 1 to 8 bands at one direction, in straight lines. Written by `cargo run -p haarmonic-generate`.\n\n\
         use crate::Real;\n",
    );
    for bands in 1..=MOST {
        let body = body(bands);
        let direction = ["_, _, _", "x, y, z"][usize::from(bands > 1)];
        text += &format!(
            "\n/// {} multiplications, {} additions.\n#[rustfmt::skip]\n#[inline(always)]\n\
             pub(super) fn eval_{bands}<T: Real>([{direction}]: [T; 3], out: &mut [T; {}]) {{\n",
            body.multiplications,
            body.additions,
            bands * bands
        );
        text.extend(body.body.lines().map(|line| format!("{}\n", &line[4..])));
        text += "}\n";
    }
    Output { path: "src/sh/expansion/basis.rs".into(), text }
}
