//! The optics against published and independently computed tables (`tests/reference/`).

use sky_core::haze::{self, Haze};
use sky_core::quantity::{Angle, Length};
use sky_sim::optics::{Constituents, OpticalProfile, OpticsSettings};
use sky_sim::profile::{AtmosphereProfile, ProfileError};
use sky_sim::rayleigh::{cross_section_m2, depolarization, king_factor, refractivity};
use sky_sim::smarts::{BeamOverrides, DirectBeam, slant_columns, vertical_columns};
use sky_sim::solar::SolarSpectrum;
use sky_sim::table::TableError;
use std::collections::BTreeMap;
use std::error::Error;

type Outcome = Result<(), Box<dyn Error>>;
type Row = BTreeMap<String, f64>;

/// Rows of a reference table; text cells become NaN.
fn reference(text: &str) -> Result<Vec<Row>, csv::Error> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
    reader
        .records()
        .map(|record| {
            let record = record?;
            let cells = record.iter().map(|cell| cell.parse().unwrap_or(f64::NAN));
            Ok(header.iter().cloned().zip(cells).collect())
        })
        .collect()
}

#[test]
fn rayleigh_table() -> Outcome {
    // Five digits of the refractive index and seven of the cross-section are printed.
    let rows = reference(include_str!("../reference/rayleigh.csv"))?;
    assert_eq!(rows.len(), 10);
    for row in rows {
        let nm = row["wavelength_nm"];
        let close = |found: f64, column: &str, limit: f64| {
            let deviation = (found / row[column] - 1.0).abs();
            assert!(deviation <= limit, "{column} at {nm} nm: {deviation:e}");
        };
        close(refractivity(nm), "n_minus_1_288K_1013hPa", 1e-8);
        close(king_factor(nm), "king_factor", 1e-8);
        close(depolarization(nm), "depolarisation_rho", 2e-6);
        close(1e4 * cross_section_m2(nm), "cross_section_cm2", 1e-7);
    }
    Ok(())
}

#[test]
fn optical_depths_of_the_general_atmosphere() -> Outcome {
    let rows = reference(include_str!("../reference/reference_optical_depth.csv"))?;
    assert_eq!(rows.len(), 105);
    let mut worst: f64 = 0.0;
    let profile = AtmosphereProfile::general();
    for row in rows {
        let depth = |only: fn(&mut Constituents)| -> Result<f64, Box<dyn Error>> {
            let mut settings = OpticsSettings {
                wavelength_nm: vec![row["wavelength_nm"]],
                haze: Haze::OpticalDepth500(row["aod500"]),
                ..OpticsSettings::default()
            };
            only(&mut settings.constituents);
            let optics = OpticalProfile::build(&profile, &settings)?;
            Ok(optics.vertical_optical_depth(Length::from_km(row["altitude_km"]))[0])
        };
        let mut check = |found: f64, want: f64, what: &str| {
            let deviation = if want > 0.0 {
                (found / want - 1.0).abs()
            } else {
                found
            };
            assert!(deviation <= 1e-3, "{what} {row:?}: {found:e} {want:e}");
            worst = worst.max(deviation);
        };
        check(depth(|_| ())?, row["tau_total_without_optional"], "total");
        check(
            depth(|c| (c.ozone, c.aerosol) = (false, false))?,
            row["tau_rayleigh"],
            "Rayleigh",
        );
        check(
            depth(|c| (c.rayleigh, c.aerosol) = (false, false))?,
            row["tau_ozone"],
            "ozone",
        );
        check(
            depth(|c| (c.rayleigh, c.ozone) = (false, false))?,
            row["tau_aerosol_troposphere"] + row["tau_aerosol_stratosphere"],
            "aerosol",
        );
        check(
            depth(|c| (c.rayleigh, c.ozone, c.aerosol, c.no2) = (false, false, false, true))?,
            row["tau_no2_optional"],
            "NO2",
        );
        check(
            depth(|c| (c.rayleigh, c.ozone, c.aerosol, c.o2o2) = (false, false, false, true))?,
            row["tau_o2o2_optional"],
            "O2-O2",
        );
    }
    assert!(worst > 0.0, "the comparison compared something");
    Ok(())
}

#[test]
fn turbidity_table() -> Outcome {
    let rows = reference(include_str!("../reference/turbidity_aod_visibility.csv"))?;
    assert_eq!(rows.len(), 18);
    for row in rows {
        let aod = row["aod_500nm"];
        // Half a unit of the last printed digit, plus what that of the optical depth moves.
        let print = |found: f64, column: &str, unit: f64, slope: f64| {
            let slack = 0.5 * unit + 0.5e-4 * slope.abs() + 1e-9;
            assert!(
                (found - row[column]).abs() <= slack,
                "{column} {row:?}: {found}"
            );
        };
        let turbidity = Haze::OpticalDepth500(aod).turbidity()?;
        print(turbidity, "turbidity_T_at_500nm", 1e-3, 1.0 / 0.14344);
        let beta = haze::angstrom_beta_from_optical_depth_500(aod, 1.3);
        print(beta, "angstrom_beta_alpha1.3", 1e-4, 0.41);
        // the table has no aerosol of the stratosphere and no ozone
        let with_layer = aod + haze::STRATOSPHERIC_OPTICAL_DEPTH_500;
        let range_km = Haze::OpticalDepth500(with_layer).visual_range()?.km();
        let ozone_per_km = haze::CLEAN_AIR_EXTINCTION_550_PER_KM - 0.01149;
        let range_km = 3.912 / (3.912 / range_km - ozone_per_km);
        let slope = range_km * range_km / 3.912 / 1.2 / 1.096;
        print(range_km, "meteorological_range_km", 0.1, slope);
    }
    Ok(())
}

#[test]
fn direct_beam_of_astm_g173() -> Outcome {
    // Conditions of the standard (SMARTS 2.9.2): air mass 1.5 at an apparent zenith angle of 48.236°,
    // 0.3438 atm-cm of ozone, 1.416 cm of water, aerosol optical depth 0.084 at 500 nm.
    let rows = reference(include_str!("../reference/astm_g173_direct_global.csv"))?;
    let wavelength_nm: Vec<f64> = rows.iter().map(|r| r["wavelength_nm"]).collect();
    let settings = OpticsSettings {
        wavelength_nm: wavelength_nm.clone(),
        haze: Haze::OpticalDepth500(0.084),
        constituents: Constituents::ALL,
        ..OpticsSettings::default()
    };
    let overrides = BeamOverrides {
        ozone_atm_cm: Some(0.3438),
        water_cm: Some(1.416),
        pressure_hpa: Some(1013.25),
    };
    let sun = SolarSpectrum {
        wavelength_nm: wavelength_nm.clone(),
        irradiance_w_m2_nm: rows.iter().map(|r| r["extraterrestrial_W_m2_nm"]).collect(),
    };
    let deviation = |settings: &OpticsSettings| -> Result<f64, Box<dyn Error>> {
        let beam = DirectBeam::new(&AtmosphereProfile::general(), settings, overrides)?;
        let zenith = Angle::from_degrees(48.236);
        let found = beam.normal_irradiance(Length::ZERO, zenith, &sun)?;
        let (mut sum, mut count) = (0.0, 0.0);
        for ((nm, found), row) in wavelength_nm.iter().zip(found).zip(&rows) {
            if (400.0..=700.0).contains(nm) {
                sum += (found / row["direct_circumsolar_W_m2_nm"] - 1.0).powi(2);
                count += 1.0;
            }
        }
        assert!(count > 300.5, "every nanometre was compared");
        Ok(f64::sqrt(sum / count))
    };
    let full = deviation(&settings)?;
    assert!(full <= 0.012, "RMS relative deviation {full}");
    // The other gases are needed: without them the figure is three times as large.
    let bare = OpticsSettings {
        constituents: Constituents::REFERENCE,
        ..settings
    };
    let without = deviation(&bare)?;
    assert!(without > 0.03 && without < 0.045, "without gases {without}");
    Ok(())
}

#[test]
fn straight_ray_air_masses() -> Outcome {
    let rows = reference(include_str!("../reference/reference_air_mass_straight.csv"))?;
    assert_eq!(rows.len(), 40);
    let profile = AtmosphereProfile::general();
    let haze = Length::from_km(1.2);
    for row in rows {
        let altitude = Length::from_km(row["altitude_km"]);
        let zenith = Angle::from_degrees(row["true_zenith_deg"]);
        let slant = slant_columns(&profile, haze, altitude, zenith).ok_or("the ray is free")?;
        let up = vertical_columns(&profile, haze, altitude);
        for (column, found) in [
            ("air", slant.air_per_m2 / up.air_per_m2),
            ("ozone", slant.ozone_per_m2 / up.ozone_per_m2),
            ("aerosol_troposphere_H1.2km", slant.haze / up.haze),
            (
                "aerosol_stratosphere",
                slant.stratospheric_aerosol / up.stratospheric_aerosol,
            ),
        ] {
            // Seven digits are printed.
            let deviation = (found / row[column] - 1.0).abs();
            assert!(deviation <= 1e-6, "{column} {row:?}: {found}");
        }
    }
    Ok(())
}

#[test]
fn table_3_1_of_the_report() -> Outcome {
    // T, p, T_eo, O2, CO2, O3 to the printed digits; humidity and water cannot be had from any
    // atmosphere, for they contradict each other, and are left out.
    let utm = AtmosphereProfile::utm2005();
    let vertical = include_str!("../reference/table_3_1_vertical_profiles.csv");
    let paths = include_str!("../reference/table_3_1_effective_path_lengths.csv");
    let mut compared = 0;
    for text in [vertical, paths] {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let header: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
        for record in reader.records() {
            let record = record?;
            let row = utm.row(Length::from_km(record[0].parse()?));
            for (name, printed) in header.iter().zip(&record) {
                let found = match name.as_str() {
                    "air_temperature_K" => row.temperature_k,
                    "pressure_mb" => row.pressure_hpa,
                    "ozone_effective_temperature_K" => row.ozone_effective_temperature_k,
                    "o2_path_km" => row.o2_path_km,
                    "co2_path_km" => row.co2_path_km,
                    "o3_column_atm_cm" => row.ozone_column_atm_cm,
                    _ => continue,
                };
                // Half a unit of the column's digits; 288.15 may round either way.
                let digits = if matches!(name.as_str(), "air_temperature_K") {
                    1
                } else {
                    printed
                        .split_once('.')
                        .map_or(0, |(_, decimals)| decimals.len())
                };
                let slack = 0.5 * 10.0_f64.powi(-i32::try_from(digits)?) * (1.0 + 1e-9);
                let want: f64 = printed.parse()?;
                assert!(
                    (found - want).abs() <= slack,
                    "{name} at {} km: {found}, printed {printed}",
                    &record[0]
                );
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 30);
    Ok(())
}

#[test]
fn shipped_profiles_are_fine_below_30_km() -> Outcome {
    for (name, text, ozone_atm_cm, water_cm) in [
        (
            "general",
            include_str!("../../profiles/general.csv"),
            0.3434,
            1.416,
        ),
        (
            "utm2005",
            include_str!("../../profiles/utm2005.csv"),
            0.3434,
            1.416,
        ),
        (
            "tropical",
            include_str!("../../profiles/tropical.csv"),
            0.282,
            4.11,
        ),
        (
            "subarctic_winter",
            include_str!("../../profiles/subarctic_winter.csv"),
            0.375,
            0.416,
        ),
    ] {
        let profile = AtmosphereProfile::from_csv_str(name, text)?;
        assert_eq!(profile.continued_above(), None, "{name}");
        for pair in profile.altitude_km().windows(2) {
            assert!(
                pair[0] >= 30.0 || pair[1] - pair[0] <= 2.0,
                "{name} at {} km",
                pair[0]
            );
        }
        let ground = profile.row(Length::ZERO);
        assert!(
            (ground.ozone_column_atm_cm - ozone_atm_cm).abs() < 1e-3,
            "{name}"
        );
        // utm2005 integrates the same water on coarser nodes.
        assert!(
            (ground.water_column_cm / water_cm - 1.0).abs() < 0.03,
            "{name}"
        );
    }
    Ok(())
}

const GOOD: &str = "altitude_km,temperature_k,pressure_hpa,ozone_number_density_per_m3
0,288,1013,7e17
10,223,265,1e18
20,217,55,4.8e18
30,227,12,2.5e18
";

#[test]
fn a_short_profile_is_continued_and_says_so() -> Outcome {
    let profile = AtmosphereProfile::from_csv_str("p.csv", GOOD)?;
    assert_eq!(profile.continued_above(), Some(Length::from_km(30.0)));
    let general = AtmosphereProfile::general();
    let ratio = |km| {
        let z = Length::from_km(km);
        profile.pressure_hpa(z) / general.pressure_hpa(z)
    };
    assert!((ratio(60.0) / ratio(30.0) - 1.0).abs() < 1e-9);
    // Air from p/(k T).
    let air = profile.row(Length::ZERO).air_number_density_per_m3;
    assert!((air * 1.380_649e-23 * 288.0 / 101_300.0 - 1.0).abs() < 1e-12);
    Ok(())
}

#[test]
fn gaps_and_column_order_do_not_matter() -> Outcome {
    let shuffled = "# a comment\npressure_hpa,altitude_km,ozone_number_density_per_m3,temperature_k
1000,0,1e18,280\n,5,,\n300,10,4e18,260\n70,20,4e18,220\n15,30,4e18,220\n";
    let profile = AtmosphereProfile::from_csv_str("p.csv", shuffled)?;
    let middle = profile.row(Length::from_km(5.0));
    let mean = (1000.0 * 300.0_f64).sqrt();
    assert!((middle.pressure_hpa - mean).abs() < 1e-9, "log-linear");
    assert!(
        (middle.ozone_number_density_per_m3 / 2e18 - 1.0).abs() < 1e-12,
        "log-linear"
    );
    assert!((middle.temperature_k - 270.0).abs() < 1e-12, "linear");
    let humid = GOOD
        .replace('\n', ",50\n")
        .replacen(",50\n", ",relative_humidity_percent\n", 1);
    let profile = AtmosphereProfile::from_csv_str("p.csv", &humid)?;
    assert!((profile.relative_humidity_percent(Length::from_km(10.0)) - 50.0).abs() < 1e-9);
    Ok(())
}

/// The error of a text, which must be one, with its message.
fn refusal(text: &str) -> Result<(ProfileError, String), &'static str> {
    match AtmosphereProfile::from_csv_str("p.csv", text) {
        Ok(_) => Err("the profile was accepted"),
        Err(error) => {
            let message = error.to_string();
            Ok((error, message))
        }
    }
}

macro_rules! refused {
    ($name:ident, $text:expr, $pattern:pat, $($part:literal),+) => {
        #[test]
        fn $name() -> Outcome {
            let (error, message) = refusal(&$text)?;
            assert!(matches!(error, $pattern), "{error:?}");
            for part in [$($part),+] {
                assert!(message.contains(part), "{message:?} lacks {part:?}");
            }
            Ok(())
        }
    };
}

refused!(
    a_missing_column_is_named,
    GOOD.replace(",ozone_number_density_per_m3", "")
        .replace(",7e17", "")
        .replace(",1e18", "")
        .replace(",4.8e18", "")
        .replace(",2.5e18", ""),
    ProfileError::Table(TableError::MissingColumn {
        line: 1,
        column: "ozone_number_density_per_m3",
        ..
    }),
    "p.csv:1:",
    "ozone_number_density_per_m3"
);
refused!(
    a_wrong_unit_suggests_the_right_one,
    GOOD.replace("temperature_k", "temperature_c"),
    ProfileError::Table(TableError::WrongUnit {
        expected: "temperature_k",
        ..
    }),
    "p.csv:1:",
    "temperature_c",
    "temperature_k"
);
refused!(
    an_unknown_column_is_named,
    GOOD.replace('\n', ",1\n")
        .replacen(",1\n", ",wind_m_s\n", 1),
    ProfileError::Table(TableError::UnknownColumn { .. }),
    "p.csv:1:",
    "wind_m_s"
);
refused!(
    a_column_given_twice_is_named,
    GOOD.replace('\n', ",1\n")
        .replacen(",1\n", ",pressure_hpa\n", 1),
    ProfileError::Table(TableError::DuplicateColumn {
        column: "pressure_hpa",
        ..
    }),
    "p.csv:1:",
    "pressure_hpa",
    "twice"
);
refused!(
    text_for_a_number,
    GOOD.replace("265", "2x5"),
    ProfileError::Table(TableError::NotANumber {
        line: 3,
        column: "pressure_hpa",
        ..
    }),
    "p.csv:3:",
    "pressure_hpa",
    "2x5"
);
refused!(
    not_a_number_at_all,
    GOOD.replace("265", "NaN"),
    ProfileError::Table(TableError::NotFinite {
        line: 3,
        column: "pressure_hpa",
        ..
    }),
    "p.csv:3:",
    "pressure_hpa",
    "finite",
    "NaN"
);
refused!(
    an_infinity,
    GOOD.replace("217", "inf"),
    ProfileError::Table(TableError::NotFinite {
        line: 4,
        column: "temperature_k",
        ..
    }),
    "p.csv:4:",
    "temperature_k",
    "inf"
);
refused!(
    a_negative_pressure,
    GOOD.replace("265", "-265"),
    ProfileError::Table(TableError::OutOfRange {
        line: 3,
        column: "pressure_hpa",
        ..
    }),
    "p.csv:3:",
    "pressure_hpa",
    "-265"
);
refused!(
    a_negative_density,
    GOOD.replace("1e18", "-1e18"),
    ProfileError::Table(TableError::OutOfRange {
        line: 3,
        column: "ozone_number_density_per_m3",
        ..
    }),
    "p.csv:3:",
    "ozone_number_density_per_m3"
);
refused!(
    a_temperature_in_celsius,
    GOOD.replace("288", "15"),
    ProfileError::Table(TableError::OutOfRange {
        line: 2,
        column: "temperature_k",
        ..
    }),
    "p.csv:2:",
    "temperature_k",
    "15"
);
refused!(
    altitudes_that_do_not_ascend,
    GOOD.replace("\n20,", "\n10,"),
    ProfileError::Table(TableError::NotAscending {
        line: 4,
        column: "altitude_km",
        ..
    }),
    "p.csv:4:",
    "altitude_km",
    "10"
);
refused!(
    a_profile_that_ends_too_low,
    GOOD.replace("\n30,", "\n29,"),
    ProfileError::NotCovering { line: 5, .. },
    "p.csv:5:",
    "0 to 30",
    "29"
);
refused!(
    a_profile_that_starts_too_high,
    GOOD.replace("\n0,", "\n1,"),
    ProfileError::NotCovering { line: 2, .. },
    "p.csv:2:",
    "0 to 30",
    "1"
);
refused!(
    an_empty_file,
    "",
    ProfileError::Table(TableError::Empty { .. }),
    "p.csv:1:",
    "empty",
    "altitude_km"
);
refused!(
    a_header_alone,
    "altitude_km,temperature_k,pressure_hpa,ozone_number_density_per_m3\n",
    ProfileError::Table(TableError::TooFewRows {
        expected: 4,
        found: 0,
        ..
    }),
    "p.csv:1:",
    "4",
    "0"
);
refused!(
    a_ragged_row,
    GOOD.replace("265,1e18", "265"),
    ProfileError::Table(TableError::RaggedRow {
        line: 3,
        expected: 4,
        found: 3,
        ..
    }),
    "p.csv:3:",
    "4",
    "3"
);
refused!(
    an_empty_altitude,
    GOOD.replace("\n10,", "\n,"),
    ProfileError::Table(TableError::EmptyCell {
        line: 3,
        column: "altitude_km",
        ..
    }),
    "p.csv:3:",
    "altitude_km",
    "empty"
);
refused!(
    a_gap_at_the_end,
    GOOD.replace("12,2.5e18", ",2.5e18"),
    ProfileError::GapAtEnd {
        line: 5,
        column: "pressure_hpa",
        ..
    },
    "p.csv:5:",
    "pressure_hpa",
    "empty"
);
refused!(
    water_said_twice,
    GOOD.replace('\n', ",1,1\n").replacen(
        ",1,1\n",
        ",water_number_density_per_m3,relative_humidity_percent\n",
        1
    ),
    ProfileError::ConflictingColumns { .. },
    "p.csv:1:",
    "water_number_density_per_m3",
    "relative_humidity_percent"
);

#[test]
fn b1_a_visual_range_is_that_of_the_optics_at_the_ground() -> Outcome {
    // 3.912 over the extinction of everything at 550 nm, in whatever air
    let profiles = [AtmosphereProfile::general(), AtmosphereProfile::utm2005()];
    for profile in profiles {
        for (scale_height_km, constituents) in [
            (1.2, Constituents::REFERENCE),
            (5.0, Constituents::REFERENCE),
            (0.3, Constituents::ALL),
        ] {
            for km in [1.0, 5.0, 23.0, 60.0, 100.0, 300.0] {
                let settings = OpticsSettings {
                    wavelength_nm: vec![450.0, 550.0],
                    haze: Haze::VisualRange(Length::from_km(km)),
                    aerosol_scale_height: Length::from_km(scale_height_km),
                    constituents,
                    ..OpticsSettings::default()
                };
                let optics = OpticalProfile::build(&profile, &settings)?;
                let extinction = optics.rayleigh_scattering_per_km[1]
                    + optics.gas_absorption_per_km[1]
                    + optics.aerosol_scattering_per_km[1]
                    + optics.aerosol_absorption_per_km[1];
                let found = 3.912 / extinction;
                assert!((found / km - 1.0).abs() < 1e-9, "{km}: {found}");
            }
        }
    }
    Ok(())
}

#[test]
fn b1_the_runtime_means_the_same_visual_range_as_the_optics() -> Outcome {
    // the conventions of `haze` are those of the general atmosphere; its levels add 0.06 %
    let profile = AtmosphereProfile::general();
    for km in [5.1, 10.0, 23.0, 60.0, 100.0, 200.0, 330.0] {
        let haze = Haze::VisualRange(Length::from_km(km));
        let settings = OpticsSettings {
            haze,
            ..OpticsSettings::default()
        };
        let (optics, runtime) = (
            haze::turbidity_from_optical_depth_500(settings.optical_depth_500(&profile)?),
            haze.turbidity()?,
        );
        assert!(
            (runtime / optics - 1.0).abs() < 1e-3,
            "{km} km: {runtime} {optics}"
        );
    }
    Ok(())
}

#[test]
fn b1_a_visual_range_longer_than_that_of_the_air_is_refused_in_kilometers() -> Outcome {
    let profile = AtmosphereProfile::general();
    let with = |km: f64, aerosol: bool| {
        let mut settings = OpticsSettings {
            haze: Haze::VisualRange(Length::from_km(km)),
            ..OpticsSettings::default()
        };
        settings.constituents.aerosol = aerosol;
        OpticalProfile::build(&profile, &settings).map_err(|e| e.to_string())
    };
    let message = with(500.0, true).err().unwrap_or_default();
    assert!(
        message.contains("visual range [km]") && message.contains("333.97"),
        "{message}"
    );
    assert!(with(333.9, true).is_ok());
    assert!(with(f64::NAN, true).is_err() && with(0.0, true).is_err());
    let message = with(23.0, false).err().unwrap_or_default();
    assert!(
        message.contains("aerosol") && message.contains("switched off"),
        "{message}"
    );
    Ok(())
}
