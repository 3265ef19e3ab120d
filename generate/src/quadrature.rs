//! Products by quadrature: what one pair of nodes, z and −z, adds to the coefficients of the product.
//!
//! At a node a factor is the trigonometric polynomial Σ_m α_m e^{imφ}, α_{−m} the conjugate of α_m = c_m − i s_m. Its
//! even and odd parts in z are sums over the l with l − m even and odd. The coefficients of the product of two are
//!
//!   H_M = Σ_{m + m' = M} α_m β_m',   and for m, m' > 0 the four products
//!   cc, ss, cs, sc serve both H_{m+m'} and H_{|m−m'|}.
//!
//! Even M come from m, m' of equal parity and odd ones from the others, so that half of the sums are in registers at a
//! time.

use crate::text::{Text, positive};

/// Names of the coefficients of one trigonometric polynomial: cosines and sines by m.
fn name(factor: &str, pole: &str, part: &str, m: usize) -> String {
    format!("{factor}{pole}{part}{m}")
}

fn flat(l: usize, m: isize) -> usize {
    ((l * l + l) as isize + m) as usize
}

/// Place of (l, m), m ≥ 0, in the tables: m by m.
fn place(bands: usize, l: usize, m: usize) -> usize {
    (0..m).map(|m| bands - m).sum::<usize>() + l - m
}

const POLES: [&str; 2] = ["n", "s"];

fn parts(m: usize) -> &'static [&'static str] {
    if m == 0 { &["c"] } else { &["c", "s"] }
}

fn signed(part: &str, m: usize) -> isize {
    if part == "s" { -(m as isize) } else { m as isize }
}

/// The values of a factor's Fourier coefficients at the two nodes.
fn evaluate(text: &mut Text, bands: usize, factor: &str, orders: std::ops::Range<usize>) {
    for m in orders {
        for part in parts(m) {
            let half = |text: &mut Text, first: usize| {
                let terms: Vec<String> = (first..bands)
                    .step_by(2)
                    .map(|l| {
                        let (c, x) = (place(bands, l, m), flat(l, signed(part, m)));
                        text.times(&format!("p.constant({c})"), &format!("p.{factor}({x})"))
                    })
                    .collect();
                text.sum(&positive(terms))
            };
            let [north, south] = POLES.map(|pole| name(factor, pole, part, m));
            let even = half(text, m);
            if m + 1 == bands {
                text.set(&north, &even);
                text.set(&south, &north);
                continue;
            }
            text.set("even", &even);
            let odd = half(text, m + 1);
            text.set("odd", &odd);
            text.set(&north, "even + odd");
            text.set(&south, "even - odd");
            text.additions += 2;
        }
    }
}

/// Sums that grow term by term.
struct Sums {
    terms: Vec<[usize; 2]>,
}

impl Sums {
    fn new(bands: usize) -> Self {
        Self { terms: vec![[0; 2]; bands] }
    }

    /// H_m part `part` += `value`, of `additions` operations itself.
    fn add(&mut self, text: &mut Text, pole: &str, (part, m): (&str, usize), value: &str, additions: usize) {
        let name = name("h", pole, part, m);
        let count = &mut self.terms[m][usize::from(part == "s")];
        text.additions += additions;
        if *count == 0 {
            text.line(&format!("let mut {name} = {value};"));
        } else {
            text.additions += 1;
            text.line(&format!("{name} = {name} + ({value});"));
        }
        *count += 1;
    }
}

/// cc ± ss and sc ± cs of a pair of orders to the sums that they belong to.
fn distribute(text: &mut Text, sums: &mut Sums, bands: usize, pole: &str, (m1, m2): (usize, usize)) {
    if m1 + m2 < bands {
        sums.add(text, pole, ("c", m1 + m2), "cc - ss", 1);
        sums.add(text, pole, ("s", m1 + m2), "cs + sc", 1);
    }
    sums.add(text, pole, ("c", m1.abs_diff(m2)), "cc + ss", 1);
    if m1 != m2 {
        sums.add(text, pole, ("s", m1.abs_diff(m2)), if m1 > m2 { "sc - cs" } else { "cs - sc" }, 1);
    }
}

/// The Fourier coefficients H of the product at one node, M of one parity.
fn convolve(text: &mut Text, bands: usize, pole: &str, parity: usize) {
    let mut sums = Sums::new(bands);
    for m in (1..bands).filter(|m| m % 2 == parity) {
        for part in parts(m) {
            let [a0, b0] = ["a", "b"].map(|f| name(f, pole, "c", 0));
            let [a, b] = ["a", "b"].map(|f| name(f, pole, part, m));
            let terms = [text.times(&a0, &b), text.times(&a, &b0)];
            let sum = text.sum(&positive(terms));
            sums.add(text, pole, (part, m), &sum, 0);
        }
    }
    for m1 in 1..bands {
        for m2 in (1..bands).filter(|m2| (m1 + m2) % 2 == parity) {
            for (product, [part1, part2]) in
                [("cc", ["c", "c"]), ("ss", ["s", "s"]), ("cs", ["c", "s"]), ("sc", ["s", "c"])]
            {
                if product == "cc" || product == "ss" || m1 != m2 || m1 + m2 < bands {
                    let value = text.times(&name("a", pole, part1, m1), &name("b", pole, part2, m2));
                    text.set(product, &value);
                }
            }
            distribute(text, &mut sums, bands, pole, (m1, m2));
        }
    }
    if parity == 0 {
        let [a, b, h] = ["a", "b", "h"].map(|f| name(f, pole, "c", 0));
        let value = text.times(&a, &b);
        text.additions += 2;
        text.set(&h, &format!("{value} + ({h} + {h})"));
    }
}

/// The same of a square, from half of the pairs.
fn convolve_square(text: &mut Text, bands: usize, pole: &str, parity: usize) {
    let mut sums = Sums::new(bands);
    for m in (1..bands).filter(|m| m % 2 == parity) {
        for part in parts(m) {
            let value = text.times(&name("a", pole, "c", 0), &name("a", pole, part, m));
            sums.add(text, pole, (part, m), &value, 0);
        }
    }
    for m1 in 1..bands {
        for m2 in (m1 + 1..bands).filter(|m2| (m1 + m2) % 2 == parity) {
            for (product, [part1, part2]) in
                [("cc", ["c", "c"]), ("ss", ["s", "s"]), ("cs", ["c", "s"]), ("sc", ["s", "c"])]
            {
                let value = text.times(&name("a", pole, part1, m1), &name("a", pole, part2, m2));
                text.set(product, &value);
            }
            distribute(text, &mut sums, bands, pole, (m1, m2));
        }
    }
    // Everything so far counts twice; the squares of single orders do not.
    if parity == 0 {
        equal_orders(text, &mut sums, bands, pole);
    } else {
        for m in (1..bands).step_by(2) {
            for part in parts(m) {
                let h = name("h", pole, part, m);
                text.additions += 1;
                text.line(&format!("{h} = {h} + {h};"));
            }
        }
    }
}

/// Doubles the sums of a square and adds α_m² to H_2m, |α_m|² to H_0.
fn equal_orders(text: &mut Text, sums: &mut Sums, bands: usize, pole: &str) {
    for m in 1..bands {
        let [c, s] = ["c", "s"].map(|part| name("a", pole, part, m));
        for (product, part) in [("cc", &c), ("ss", &s)] {
            let value = text.times(part, part);
            text.set(product, &value);
        }
        sums.add(text, pole, ("c", 0), "cc + ss", 1);
        if 2 * m < bands {
            let cs = text.times(&c, &s);
            text.set("cs", &cs);
            let [hc, hs] = ["c", "s"].map(|part| name("h", pole, part, 2 * m));
            text.line(&format!("{hc} = ({hc} + {hc}) + (cc - ss);"));
            text.line(&format!("{hs} = {hs} + cs;"));
            text.line(&format!("{hs} = {hs} + {hs};"));
            text.additions += 5;
        }
    }
    let [a, h] = ["a", "h"].map(|f| name(f, pole, "c", 0));
    let value = text.times(&a, &a);
    text.additions += 2;
    text.set(&h, &format!("{value} + ({h} + {h})"));
}

/// Projects H at the two nodes.
fn project(text: &mut Text, bands: usize) {
    let count = bands * (bands + 1) / 2;
    for m in 0..bands {
        for part in parts(m) {
            let [north, south] = POLES.map(|pole| name("h", pole, part, m));
            for first in [m, m + 1] {
                if first >= bands {
                    continue;
                }
                text.additions += 1;
                text.set("h", &format!("{north} {} {south}", if first == m { "+" } else { "-" }));
                for l in (first..bands).step_by(2) {
                    let value = text.times(&format!("p.constant({})", count + place(bands, l, m)), "h");
                    text.additions += 1;
                    text.line(&format!("p.give({}, {value});", flat(l, signed(part, m))));
                }
            }
        }
    }
}

/// What a pair of nodes adds to a product.
pub(crate) fn product(bands: usize) -> Text {
    let mut text = Text::default();
    for factor in ["a", "b"] {
        evaluate(&mut text, bands, factor, 0..bands);
    }
    for pole in POLES {
        for parity in [0, 1] {
            convolve(&mut text, bands, pole, parity);
        }
    }
    project(&mut text, bands);
    text
}

/// What a pair of nodes adds to a square.
pub(crate) fn square(bands: usize) -> Text {
    let mut text = Text::default();
    evaluate(&mut text, bands, "a", 0..bands);
    for pole in POLES {
        for parity in [0, 1] {
            convolve_square(&mut text, bands, pole, parity);
        }
    }
    project(&mut text, bands);
    text
}

/// What the two poles add: there only m = 0 lives.
pub(crate) fn poles(bands: usize, factors: [&str; 2]) -> Text {
    let mut text = Text::default();
    let mut evaluated = Vec::new();
    for factor in factors {
        if !evaluated.contains(&factor) {
            evaluate(&mut text, bands, factor, 0..1);
            evaluated.push(factor);
        }
    }
    let values = POLES.map(|pole| {
        let [a, b] = factors.map(|f| name(f, pole, "c", 0));
        text.times(&a, &b)
    });
    for (pole, value) in POLES.into_iter().zip(values) {
        text.set(&name("h", pole, "c", 0), &value);
    }
    let count = bands * (bands + 1) / 2;
    for first in [0, 1] {
        text.additions += 1;
        text.set("h", &format!("hnc0 {} hsc0", if first == 0 { "+" } else { "-" }));
        for l in (first..bands).step_by(2) {
            let value = text.times(&format!("p.constant({})", count + l), "h");
            text.line(&format!("p.give({}, {value});", flat(l, 0)));
        }
    }
    text
}
