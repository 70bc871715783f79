//! Grid files: the nodes of a table as TOML.

use anyhow::{Result, anyhow};
use serde::Deserialize;
use sky_core::axis::Axis;
use sky_core::lut::Form;
use sky_fit::sweep::Grid;

/// A grid file: the axes, and optionally the form.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct GridFile {
    altitude_km: Vec<f64>,
    turbidity: Vec<f64>,
    sun_zenith_deg: Vec<f64>,
    #[serde(default = "extended")]
    form: Form,
}

const fn extended() -> Form {
    Form::Extended
}

/// A grid from the text of a TOML file; `name` goes before messages.
///
/// # Errors
/// When it is no such file, or its axes are wrong or outside what the engines answer for.
pub fn parse_grid(name: &str, text: &str) -> Result<Grid> {
    let file: GridFile = toml::from_str(text).map_err(|e| anyhow!("{name}: {e}"))?;
    let axis = |column: &str, unit: &str, nodes: Vec<f64>, [low, high]: [f64; 2]| -> Result<Axis> {
        let axis = Axis::new(unit, nodes).map_err(|e| anyhow!("{name}: {column}: {e}"))?;
        let found = axis.bounds();
        if found[0] < low || found[1] > high {
            return Err(anyhow!(
                "{name}: {column}: expected nodes within {low} to {high}, found {} to {}",
                found[0],
                found[1]
            ));
        }
        Ok(axis)
    };
    Ok(Grid {
        altitude_km: axis("altitude_km", "km", file.altitude_km, [0.0, 30.0])?,
        turbidity: axis("turbidity", "1", file.turbidity, [1.0, 12.0])?,
        sun_zenith_deg: axis("sun_zenith_deg", "deg", file.sun_zenith_deg, [0.0, 96.0])?,
        form: file.form,
    })
}
