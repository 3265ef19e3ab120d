//! Numbers as the run-time libraries of other programs print them.

/// The number that a word of a text file spells.
///
/// Beside the decimals and the `nan`, `inf` and `infinity` of IEEE 754 in any case and with any sign: `nan(ind)`,
/// `nan(snan)`, `nan(0x7ff8…)` and `nanq` (C libraries), `1.#QNAN`, `1.#IND`, `1.#SNAN`, `1.#INF` and what rounding to
/// fewer characters makes of them, `1.#R`, `1.#J` (Microsoft's, before 2015), and exponents with the D of Fortran.
pub(super) fn parse(word: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(word).ok()?;
    if let Ok(number) = text.parse() {
        return Some(number);
    }
    let text = text.to_ascii_lowercase();
    let (sign, rest) = match text.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, text.strip_prefix('+').unwrap_or(&text)),
    };
    let nan = |form: &str| {
        let payload = form.strip_prefix('(').is_some_and(|f| f.ends_with(')'));
        payload || matches!(form, "" | "q" | "s")
    };
    if let Some(form) = rest.strip_prefix("1.#") {
        let infinite = form.starts_with("inf") || form == "j" || form == "io";
        let known = infinite || ["qn", "sn", "ind", "nan", "r", "q", "s"].iter().any(|k| form.starts_with(k));
        return known.then_some(if infinite { sign * f64::INFINITY } else { f64::NAN });
    }
    if rest.strip_prefix("nan").is_some_and(nan) || matches!(rest, "qnan" | "snan") {
        return Some(f64::NAN);
    }
    // The mantissa is a decimal: no word such as "infd" gets here.
    let (mantissa, exponent) = text.split_once('d')?;
    mantissa
        .ends_with(|c: char| c.is_ascii_digit() || c == '.')
        .then(|| format!("{mantissa}e{exponent}").parse().ok())?
}

#[cfg(test)]
mod tests {
    use super::parse;

    #[test]
    fn spellings() {
        for word in [
            "nan",
            "NaN",
            "-nan",
            "+NAN",
            "-nan(ind)",
            "nan(ind)",
            "nan(snan)",
            "-NaN(snan)",
            "nan(0x7ff8000)",
            "NaNQ",
            "nanS",
            "QNAN",
            "1.#QNAN",
            "-1.#QNAN0",
            "1.#QNB",
            "-1.#IND",
            "-1.#IND00",
            "1.#SNAN",
            "1.#NAN",
            "1.#R",
            "-1.#Q",
        ] {
            assert!(parse(word.as_bytes()).is_some_and(f64::is_nan), "{word}");
        }
        for word in ["inf", "Infinity", "+INF", "1.#INF", "1.#INF00", "1.#J", "1.#IO", "1e999"] {
            assert_eq!(parse(word.as_bytes()), Some(f64::INFINITY), "{word}");
            assert_eq!(parse(format!("-{word}").replace("-+", "-").as_bytes()), Some(f64::NEG_INFINITY), "{word}");
        }
        for (word, number) in
            [("1.5", 1.5), ("-.5", -0.5), ("+3.", 3.0), ("1.5D+02", 150.0), ("-2d0", -2.0), ("4e-1", 0.4)]
        {
            assert_eq!(parse(word.as_bytes()), Some(number), "{word}");
        }
        for word in ["", "-", "1,5", "nanx", "1.#", "1.#X", "0x10", "1.5.2", "infd", "d5", "1d", "nan(ind", "é", "--1"]
        {
            assert_eq!(parse(word.as_bytes()), None, "{word}");
        }
        assert_eq!(parse(b"\xff"), None);
    }
}
