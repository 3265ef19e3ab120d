//! Products by the tensor: every unordered pair of coefficients once, equal |Γ| of an output summed before they are
//! multiplied.

use std::collections::HashMap;

use haarmonic::sh::TripleTensor;

use crate::text::{Text, positive};

/// ± x_i x_j.
type Term = (bool, usize, usize);

/// For output k the sums of pairs with their common Γ, pairs with the constant function left out.
fn groups(tensor: &TripleTensor, k: usize) -> Vec<(f64, Vec<Term>)> {
    let count = tensor.bands() * tensor.bands();
    let mut groups: Vec<(f64, Vec<Term>)> = Vec::new();
    for i in 1..count {
        for j in i..count {
            let gamma = tensor.value(i, j, k);
            if gamma == 0.0 {
                continue;
            }
            let same = groups.iter_mut().find(|(value, _)| (value.abs() - gamma.abs()).abs() < 1e-13 * gamma.abs());
            match same {
                Some((value, terms)) => terms.push(((*value < 0.0) != (gamma < 0.0), i, j)),
                None => groups.push((gamma, vec![(false, i, j)])),
            }
        }
    }
    groups
}

/// Products of pairs and their sums, each written when it is first wanted.
struct Pairs {
    square: bool,
    pairs: HashMap<(usize, usize), String>,
    sums: HashMap<Vec<Term>, String>,
}

impl Pairs {
    /// a_i b_j + a_j b_i, of a square a_i a_j.
    fn pair(&mut self, text: &mut Text, i: usize, j: usize) -> String {
        if let Some(name) = self.pairs.get(&(i, j)) {
            return name.clone();
        }
        let name = format!("p{i}_{j}");
        let value = match (self.square, i == j) {
            (true, _) => text.times(&format!("a{i}"), &format!("a{j}")),
            (false, true) => text.times(&format!("a{i}"), &format!("b{i}")),
            (false, false) => {
                let terms =
                    [text.times(&format!("a{i}"), &format!("b{j}")), text.times(&format!("a{j}"), &format!("b{i}"))];
                text.sum(&positive(terms))
            }
        };
        text.set(&name, &value);
        self.pairs.insert((i, j), name.clone());
        name
    }

    fn sum(&mut self, text: &mut Text, terms: &[Term]) -> String {
        if let Some(name) = self.sums.get(terms) {
            return name.clone();
        }
        let named: Vec<(bool, String)> =
            terms.iter().map(|&(negative, i, j)| (negative, self.pair(text, i, j))).collect();
        if let [(_, name)] = &named[..] {
            return name.clone();
        }
        let name = format!("s{}", self.sums.len());
        let value = text.sum(&named);
        text.set(&name, &value);
        self.sums.insert(terms.to_vec(), name.clone());
        name
    }
}

/// In a square a pair of different coefficients counts twice: its Γ is doubled where a sum has no other kind, else the
/// pair.
fn weigh(square: bool, groups: Vec<(f64, Vec<Term>)>) -> Vec<(f64, Vec<Term>)> {
    if !square {
        return groups;
    }
    let mut weighed = Vec::new();
    for (gamma, terms) in groups {
        let (equal, different): (Vec<Term>, Vec<Term>) = terms.into_iter().partition(|(_, i, j)| i == j);
        for (factor, mut terms) in [(1.0, equal), (2.0, different)] {
            if let Some(&(negative, ..)) = terms.first() {
                terms.iter_mut().for_each(|term| term.0 ^= negative);
                weighed.push((if negative { -factor * gamma } else { factor * gamma }, terms));
            }
        }
    }
    weighed
}

/// h_0 = Γ Σ a_i b_i and the constant's share of the others, Γ = 1/√4π, begin the sums.
fn constant_part(text: &mut Text, pairs: &mut Pairs, count: usize, gamma: f64) {
    let factors: &[&str] = if pairs.square { &["a"] } else { &["a", "b"] };
    for factor in factors {
        for i in 0..count {
            text.set(&format!("{factor}{i}"), &format!("p.{factor}({i})"));
        }
    }
    for factor in factors {
        let constant = if pairs.square { 2.0 * gamma } else { gamma };
        let value = text.times(&format!("p.literal({constant:?})"), &format!("{factor}0"));
        text.set(&format!("{factor}_mean"), &value);
    }
    let diagonal: Vec<String> = (0..count).map(|i| pairs.pair(text, i, i)).collect();
    let sum = text.sum(&positive(diagonal));
    text.set("sum", &sum);
    let value = text.times(&format!("p.literal({gamma:?})"), "sum");
    text.line(&format!("p.give(0, {value});"));
}

/// A product of `bands` bands, or a square.
pub(crate) fn product(bands: usize, square: bool) -> Text {
    let tensor = TripleTensor::new(bands).expect("a handful of bands");
    let (mut text, count) = (Text::default(), bands * bands);
    let mut pairs = Pairs { square, pairs: HashMap::new(), sums: HashMap::new() };
    constant_part(&mut text, &mut pairs, count, tensor.value(0, 0, 0));
    for k in 1..count {
        let mut terms = vec![text.times("a_mean", &if square { format!("a{k}") } else { format!("b{k}") })];
        if !square {
            terms.push(text.times("b_mean", &format!("a{k}")));
        }
        for (gamma, group) in weigh(square, groups(&tensor, k)) {
            let sum = pairs.sum(&mut text, &group);
            terms.push(text.times(&format!("p.literal({gamma:?})"), &sum));
        }
        let sum = text.sum(&positive(terms));
        text.line(&format!("p.give({k}, {sum});"));
    }
    text
}
