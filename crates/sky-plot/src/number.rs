//! Numbers for people.

/// A number in few characters: plain between 0.001 and 100 000, else with a power of ten.
#[must_use]
pub fn short(value: f64) -> String {
    let size = value.abs();
    if size < 1e-12 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    let text = if (1e-3..1e5).contains(&size) {
        let decimals = if size < 0.01 {
            5
        } else if size < 1.0 {
            4
        } else if size < 100.0 {
            3
        } else {
            1
        };
        format!("{value:.decimals$}")
    } else {
        return format!("{value:.1e}").replace(".0e", "e");
    };
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (10.0, "10"),
            (0.25, "0.25"),
            (100_000.0, "1e5"),
            (-3.5, "-3.5"),
            (2.5e-5, "2.5e-5"),
            (400.0, "400"),
        ] {
            assert_eq!(short(value), text);
        }
    }
}
