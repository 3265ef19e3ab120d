//! The tables of the optimal linear exponential.

use std::fmt::Write;

use haarmonic::sh::OptimalLinear;

use crate::output::Output;

/// Bands whose tables are committed.
const BANDS: std::ops::RangeInclusive<usize> = 2..=8;

/// src/sh/exponential/optimal_linear_table.rs.
pub(crate) fn table() -> Output {
    let mut text = "//! α and β of the optimal linear exponential, for bands 2 to 8. Written by the crate `generate`: do not edit.\n\n\
        /// For each number of bands: the ends of the pieces in x = ‖f̂‖; for each piece c_0…c_7 of Chebyshev\n\
        /// polynomials, α and β in turn.\n\
        #[rustfmt::skip]\n"
        .to_owned();
    let count = BANDS.count();
    writeln!(text, "pub(super) const TABLES: [(&[f64], &[f64]); {count}] = [").expect("a string");
    for bands in BANDS {
        let fitted = OptimalLinear::fit(bands).expect("few bands");
        let (breaks, terms) = fitted.table();
        writeln!(text, "    // {bands} bands").expect("a string");
        text += "    (&[";
        list(&mut text, breaks, "        ");
        text += "    ], &[";
        list(&mut text, terms, "        ");
        text += "    ]),\n";
    }
    text += "];\n";
    Output { path: "src/sh/exponential/optimal_linear_table.rs".to_owned(), text }
}

/// Eight numbers a line. Ten decimal places are far below the tables' accuracy, and above what machines differ by.
fn list(text: &mut String, values: &[f64], indent: &str) {
    for row in values.chunks(8) {
        let row: Vec<String> = row.iter().map(|x| number(*x)).collect();
        write!(text, "\n{indent}{},", row.join(", ")).expect("a string");
    }
    *text += "\n";
}

fn number(x: f64) -> String {
    let rounded = format!("{x:.10}");
    let short = rounded.trim_end_matches('0');
    let short = if short.ends_with('.') { format!("{short}0") } else { short.to_owned() };
    if short == "-0.0" { "0.0".to_owned() } else { short }
}
