//! What was wrong once, by the number that it had on the list, and is right.

use sky_core::axis::Axis;
use sky_core::conditions::Conditions;
use sky_core::direction::SkyDirection;
use sky_core::haze::Haze;
use sky_core::lut::Form;
use sky_core::quantity::{Angle, Length};
use sky_eval::truth::TransportSky;
use sky_fit::sweep::{Grid, SweepError, sweep};
use sky_science::cie::ColorWeights;
use sky_science::sky_model::{SkyError, SkyModel};
use sky_science::spectrum::{Spectrum, SpectrumError, uniform_wavelengths};
use sky_sim::optics::{OpticalProfile, OpticsSettings};
use sky_sim::profile::{AtmosphereProfile, ProfileError};
use sky_sim::smarts::{BeamOverrides, DirectBeam, SmartsError, SmartsSky};
use sky_sim::solar::SolarSpectrum;
use sky_sim::transport::{Transport, TransportError, TransportSettings};

type Outcome = Result<(), Box<dyn core::error::Error>>;

/// The general atmosphere as a table, one cell of which is another.
fn general_with(column: &str, altitude_km: &str, cell: &str) -> String {
    let text = include_str!("../../profiles/general.csv");
    let header = text.lines().next().unwrap_or_default();
    let place = header.split(',').position(|name| name == column);
    text.lines()
        .map(|line| {
            let mut cells: Vec<&str> = line.split(',').collect();
            if cells[0] == altitude_km
                && let Some(place) = place
            {
                cells[place] = cell;
            }
            cells.join(",")
        })
        .collect::<Vec<_>>()
        .join("\n")
}

#[test]
fn b2_a_pressure_with_a_digit_too_few_is_refused() -> Outcome {
    let read = |column, altitude_km, cell| {
        AtmosphereProfile::from_csv_str("p.csv", &general_with(column, altitude_km, cell))
    };
    assert!(read("pressure_hpa", "5", "540.483").is_ok());
    assert!(read("pressure_hpa", "5", "").is_ok());
    for slip in ["54", "1404", "450"] {
        let Err(error) = read("pressure_hpa", "5", slip) else {
            return Err(format!("{slip} hPa at 5 km was accepted").into());
        };
        assert!(
            matches!(error, ProfileError::NotInBalance { line: 7, .. }),
            "{error}"
        );
        assert!(
            error
                .to_string()
                .contains("pressure_hpa: expected about 54"),
            "{error}"
        );
    }
    let slip = read("air_number_density_per_m3", "5", "1.53115e24");
    assert!(matches!(slip, Err(ProfileError::NotTheGas { line: 7, .. })));
    Ok(())
}

#[test]
fn b2_a_column_without_a_shape_is_refused() -> Outcome {
    // no ozone and no water anywhere
    let text: String = include_str!("../../profiles/general.csv")
        .lines()
        .enumerate()
        .map(|(row, line)| {
            let mut cells: Vec<&str> = line.split(',').collect();
            if row > 0 {
                (cells[4], cells[6]) = ("0", "0");
            }
            cells.join(",") + "\n"
        })
        .collect();
    let profile = AtmosphereProfile::from_csv_str("p.csv", &text)?;
    let at = |overrides| {
        DirectBeam::new(&profile, &OpticsSettings::default(), overrides)?
            .transmittance(Length::ZERO, Angle::ZERO)
    };
    for overrides in [
        BeamOverrides {
            ozone_atm_cm: Some(0.3),
            ..BeamOverrides::default()
        },
        BeamOverrides {
            water_cm: Some(1.4),
            ..BeamOverrides::default()
        },
    ] {
        assert!(matches!(at(overrides), Err(SmartsError::NoShape { .. })));
    }
    // none of nothing is what the profile has
    let none = BeamOverrides {
        ozone_atm_cm: Some(0.0),
        water_cm: Some(0.0),
        pressure_hpa: None,
    };
    let (own, same) = (at(BeamOverrides::default())?, at(none)?);
    assert!(own.iter().all(|t| t.is_finite() && *t > 0.0));
    assert_eq!(own, same);
    Ok(())
}

#[test]
fn b2_a_spectrum_beside_the_visible_has_no_color() -> Outcome {
    let sun = SolarSpectrum::g173();
    let sun = Spectrum::new(sun.wavelength_nm, sun.irradiance_w_m2_nm)?;
    for range in [[720.0, 800.0], [380.0, 600.0], [410.0, 780.0]] {
        let grid = uniform_wavelengths(range[0], range[1], 10.0)?;
        for weights in [
            ColorWeights::for_radiance_ratio(&grid, &sun),
            ColorWeights::for_spectral_radiance(&grid),
        ] {
            let Err(SpectrumError::NotVisible { found_nm, .. }) = weights else {
                panic!("{range:?}: {weights:?}");
            };
            assert_eq!(found_nm.map(f64::to_bits), range.map(f64::to_bits));
        }
    }
    assert!(
        ColorWeights::for_radiance_ratio(&uniform_wavelengths(405.0, 695.0, 10.0)?, &sun).is_ok()
    );
    Ok(())
}

#[test]
fn b2_a_series_that_holds_nan_has_not_converged() -> Outcome {
    let settings = OpticsSettings {
        wavelength_nm: vec![450.0, 550.0],
        ..OpticsSettings::default()
    };
    let mut optics = OpticalProfile::build(&AtmosphereProfile::general(), &settings)?;
    for g in &mut optics.aerosol_g {
        *g = f64::NAN;
    }
    let solved = Transport::solve(&optics, 0.1, &TransportSettings::default());
    assert!(matches!(solved, Err(TransportError::NotConverged { .. })));
    Ok(())
}

#[test]
fn b9_too_few_columns_are_refused() -> Outcome {
    let settings = OpticsSettings {
        wavelength_nm: vec![550.0],
        ..OpticsSettings::default()
    };
    let optics = OpticalProfile::build(&AtmosphereProfile::general(), &settings)?;
    for found in 0..4_usize {
        let settings = TransportSettings {
            columns_deg: [0.0, 60.0, 106.0][..found.min(3)].to_vec(),
            ..TransportSettings::default()
        };
        assert_eq!(
            Transport::solve(&optics, 0.1, &settings).err(),
            Some(TransportError::Columns {
                found: found.min(3)
            })
        );
    }
    Ok(())
}

#[test]
fn b3_an_engine_that_gives_up_says_so_and_so_does_the_fit() -> Outcome {
    let truth = TransportSky::new(
        AtmosphereProfile::general(),
        OpticsSettings::with_step_nm(20)?,
        0.2,
    )?
    .with_transport_settings(TransportSettings {
        most_orders: 2,
        ..TransportSettings::default()
    });
    let conditions = Conditions {
        observer_altitude: Length::ZERO,
        turbidity: 8.0,
        sun_zenith: Angle::from_degrees(60.0),
    };
    let Err(error) = truth.yxy_map(&conditions, &[SkyDirection::from_degrees(0.0, 0.0)]) else {
        return Err("two orders were enough for haze".into());
    };
    assert!(
        matches!(
            error,
            SkyError::GaveUp {
                sky: "transport",
                ..
            }
        ),
        "{error}"
    );
    assert!(error.to_string().contains("multiple scattering"), "{error}");
    let grid = Grid {
        altitude_km: Axis::new("km", vec![0.0])?,
        turbidity: Axis::new("1", vec![8.0])?,
        sun_zenith_deg: Axis::new("deg", vec![60.0])?,
        form: Form::Extended,
    };
    let swept = sweep(&truth, &grid, &|| ());
    assert!(matches!(
        swept,
        Err(SweepError::Sky(SkyError::GaveUp { .. }))
    ));
    Ok(())
}

#[test]
fn b8_the_ground_of_spctrl2_is_lit_by_corrected_sunlight() -> Outcome {
    // Bird & Riordan 1986, Eq. 3-7, as pvlib.spectrum.spectrl2 and NREL's spectrl2_2.c have it:
    // I_g = (I_d cos Z + I_r + I_a) C_s r_s r_g/(1 − r_s r_g). Two albedos give r_s and the bracket.
    let wavelength_nm = vec![380.0, 420.0, 445.0, 460.0, 600.0];
    let settings = OpticsSettings {
        wavelength_nm: wavelength_nm.clone(),
        haze: Haze::OpticalDepth500(0.1),
        ..OpticsSettings::default()
    };
    let profile = AtmosphereProfile::general();
    let unit = SolarSpectrum {
        irradiance_w_m2_nm: vec![1.0; wavelength_nm.len()],
        wavelength_nm: wavelength_nm.clone(),
    };
    let sun = Angle::from_degrees(40.0);
    let diffuse = |albedo| -> Result<Vec<f64>, SmartsError> {
        SmartsSky::new(&profile, &settings, albedo)?
            .with_sun(&unit)?
            .diffuse_irradiance(Length::ZERO, sun)
    };
    let (black, half, white) = (diffuse(0.0)?, diffuse(0.5)?, diffuse(1.0)?);
    let beam = DirectBeam::new(&profile, &settings, BeamOverrides::default())?;
    let direct = beam.transmittance(Length::ZERO, sun)?;
    for (w, nm) in wavelength_nm.iter().enumerate() {
        let (at_half, at_white) = (half[w] - black[w], white[w] - black[w]);
        let ratio = at_white / at_half;
        let sky = (ratio - 2.0) / (ratio - 1.0);
        let bracket = at_white * (1.0 - sky) / sky;
        let correction = if *nm <= 450.0 {
            ((nm + 550.0) / 1000.0).powf(1.8)
        } else {
            1.0
        };
        // the scattered light carries the correction already
        let expected = correction * sun.radians().cos() * direct[w] + black[w];
        assert!(
            (bracket / expected - 1.0).abs() < 3e-3,
            "{nm} nm: {bracket} {expected}"
        );
    }
    Ok(())
}
