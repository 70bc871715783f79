//! Small look-up tables for the tests.

use std::collections::BTreeMap;

use sky_core::axis::Axis;
use sky_core::conditions::Domain;
use sky_core::lut::{CHANNELS, ErrorQuantiles, FitStatistics, Form, Interpolation, Lut, LutHeader};

/// A header over the given axes, valid on all of them.
pub(crate) fn header(
    form: Form,
    interpolation: Interpolation,
    [altitude_km, turbidity, sun_zenith_deg]: [&[f64]; 3],
) -> LutHeader {
    let axis = |unit: &str, nodes: &[f64]| Axis::new(unit, nodes.to_vec()).expect("ascending");
    let altitude_km = axis("km", altitude_km);
    let turbidity = axis("1", turbidity);
    let sun_zenith_deg = axis("deg", sun_zenith_deg);
    let names = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect();
    let errors = |median| ErrorQuantiles {
        median,
        p95: 3.0 * median,
        max: 10.0 * median,
    };
    LutHeader {
        storage: sky_core::lut::Storage::F32,
        form,
        interpolation,
        domain: Domain {
            altitude_km: altitude_km.bounds(),
            turbidity: turbidity.bounds(),
            sun_zenith_deg: sun_zenith_deg.bounds(),
            below_horizontal: form != Form::PerezReport,
        },
        altitude_km,
        turbidity,
        sun_zenith_deg,
        channels: names(&CHANNELS),
        terms: names(form.terms()),
        profile_name: "profiles/general.csv".into(),
        profile_sha256: "0f".repeat(32),
        generator: "utm-sky 0.1.0".into(),
        engine: "transport".into(),
        settings: BTreeMap::from([
            ("ground_albedo".to_owned(), 0.2.into()),
            ("wavelength_step_nm".to_owned(), 10.into()),
        ]),
        extinction: None,
        fit: FitStatistics {
            delta_e_2000: errors(0.25),
            luminance_relative_error: errors(0.011),
        },
    }
}

/// A table whose value i is i/8.
pub(crate) fn counting(header: LutHeader) -> Lut {
    let count: usize = header.shape().iter().product::<usize>() * header.values_per_node();
    let count = u16::try_from(count).expect("a small table");
    Lut::new(header, (0..count).map(|i| f32::from(i) / 8.0).collect()).expect("a good table")
}

/// The smallest table: two nodes along each axis.
pub(crate) fn smallest() -> Lut {
    counting(header(
        Form::PerezSpherical,
        Interpolation::LogLinear,
        [&[0.0, 30.0], &[1.0, 8.0], &[0.0, 92.0]],
    ))
}

/// A table over the report's grid; optical depths 0, 0.5 and 1 as turbidities.
pub(crate) fn report_grid() -> Lut {
    counting(header(
        Form::PerezReport,
        Interpolation::ReportLagrange,
        [
            &[0.0, 6.0, 12.0, 20.0, 30.0],
            &[1.0, 4.5, 8.0],
            &[0.0, 45.0, 90.0],
        ],
    ))
}
