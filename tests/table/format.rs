//! The file format of look-up tables: what is written is read back, and nothing else is read.

use crate::lut_support::{header, report_grid, smallest};
use proptest::collection::vec;
use proptest::prelude::*;
use sky_core::axis::Axis;
use sky_core::lut::{Form, Interpolation, Lut, LutError, MAGIC, Storage, VERSION};

/// CRC-64/XZ, bit by bit: another program than the one that is tested.
fn crc(bytes: &[u8]) -> u64 {
    let mut crc = u64::MAX;
    for byte in bytes {
        crc ^= u64::from(*byte);
        for _ in 0..8 {
            let carry = crc & 1;
            crc >>= 1;
            if carry == 1 {
                crc ^= 0xC96C_5795_D787_0F42;
            }
        }
    }
    !crc
}

/// A file around any header text and data, with a right checksum.
fn file_around(header: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION.to_le_bytes());
    for n in [header.len(), data.len()] {
        bytes.extend(u32::try_from(n).expect("few").to_le_bytes());
    }
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes.extend(crc(&bytes).to_le_bytes());
    bytes
}

/// A file around any header text and values stored as f32.
fn file_with(header: &str, values: &[f32]) -> Vec<u8> {
    let data: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    file_around(header, &data)
}

/// The smallest table, its values stored in 16 bits.
fn smallest_in_16_bits() -> Lut {
    let lut = smallest();
    let mut header = lut.header().clone();
    header.storage = Storage::Linear16;
    Lut::new(header, lut.data().to_vec()).expect("a good table")
}

/// The header of the smallest table as text.
fn smallest_header() -> String {
    serde_json::to_string(smallest().header()).expect("a header")
}

/// Decodes a file with a changed header; it must not be a table.
fn refused_header(from: &str, to: &str) -> LutError {
    let text = smallest_header();
    assert!(text.contains(from), "{from} is not in {text}");
    Lut::decode(&file_with(&text.replacen(from, to, 1), smallest().data()))
        .expect_err("a wrong header")
}

#[test]
fn the_layout_is_the_documented_one() {
    let lut = smallest();
    let bytes = lut.encode();
    assert_eq!(bytes[..12], *b"\x89UTMLUT\r\n\x1a\n\0");
    let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!(number(12), 1);
    let (header, values) = (number(16), number(20));
    assert_eq!(values, 4 * 2 * 2 * 2 * 3 * 6);
    assert_eq!((24 + header) % 8, 0);
    assert_eq!(bytes.len(), 24 + header + values + 8);
    let json: serde_json::Value = serde_json::from_slice(&bytes[24..24 + header]).unwrap();
    assert_eq!(json["form"], "perez-spherical");
    assert_eq!(json["altitude_km"]["nodes"][1], 30.0);
    assert_eq!(json["terms"][0], "zenith");
    let first = 24 + header;
    assert_eq!(bytes[first + 8 * 4..][..4], 1.0_f32.to_le_bytes());
    let end = bytes.len() - 8;
    assert_eq!(bytes[end..], crc(&bytes[..end]).to_le_bytes());
    assert_eq!(
        bytes,
        file_with(std::str::from_utf8(&bytes[24..first]).unwrap(), lut.data())
    );
}

#[test]
fn the_layout_in_16_bits_is_the_documented_one() {
    let lut = smallest_in_16_bits();
    let bytes = lut.encode();
    let header = u32::from_le_bytes(bytes[16..20].try_into().unwrap()) as usize;
    let data = &bytes[24 + header..bytes.len() - 8];
    // Two f32 for each of 18 values, then 8 nodes of 18 indices.
    assert_eq!(data.len(), 18 * 8 + 8 * 18 * 2);
    let float = |at: usize| f32::from_le_bytes(data[at..at + 4].try_into().unwrap());
    // The second value of a node runs from 1/8 at the first node to 127/8 at the last.
    assert_eq!(
        [float(8), float(12)].map(f32::to_bits),
        [0.125, 127.0 / 8.0_f32].map(f32::to_bits)
    );
    let index = |node: usize| {
        let at = 18 * 8 + (node * 18 + 1) * 2;
        u16::from_le_bytes(data[at..at + 2].try_into().unwrap())
    };
    let expected = [0_u16, 9362, 18724, 28086, 37449, 46811, 56173, 65535];
    assert_eq!([0, 1, 2, 3, 4, 5, 6, 7].map(index), expected);
}

#[test]
fn values_in_16_bits_are_within_half_a_step() {
    let (exact, stored) = (smallest(), smallest_in_16_bits());
    let step = f64::from(126.0_f32 / 8.0) / 65535.0;
    for (a, b) in exact.data().iter().zip(stored.data()) {
        let difference = (f64::from(*a) - f64::from(*b)).abs();
        // Half a step, and the rounding of the value itself to f32.
        assert!(difference <= 0.5 * step + 1e-6, "{a} became {b}");
    }
    assert_eq!(exact.node(0, 0, 0), stored.node(0, 0, 0), "the least");
    assert_eq!(exact.node(1, 1, 1), stored.node(1, 1, 1), "the largest");
}

#[test]
fn the_same_table_gives_the_same_bytes() {
    assert_eq!(smallest().encode(), smallest().encode());
    let read = Lut::decode(&smallest().encode()).unwrap();
    assert_eq!(read.encode(), smallest().encode());
}

#[test]
fn nodes_are_in_order() {
    let lut = report_grid();
    let [altitudes, turbidities, suns] = lut.header().shape();
    let mut all: Vec<f32> = Vec::new();
    for a in 0..altitudes {
        for t in 0..turbidities {
            for s in 0..suns {
                assert_eq!(lut.node(a, t, s).len(), 18);
                all.extend(lut.node(a, t, s));
            }
        }
    }
    assert_eq!(all, lut.data());
}

#[test]
#[should_panic(expected = "node [0][0][3] of 5 x 3 x 3")]
fn a_node_beside_the_table_is_no_other_node() {
    let lut = report_grid();
    let _ = lut.node(0, 0, 3);
}

#[test]
fn every_truncation_is_refused() {
    for bytes in [smallest().encode(), smallest_in_16_bits().encode()] {
        for length in 0..bytes.len() {
            match Lut::decode(&bytes[..length]) {
                Err(LutError::Truncated { expected, found }) => {
                    assert_eq!(found, length as u64);
                    assert!(expected > found);
                }
                other => panic!("{length} bytes: {other:?}"),
            }
        }
    }
}

#[test]
fn every_flipped_bit_is_refused() {
    for bytes in [smallest().encode(), smallest_in_16_bits().encode()] {
        for place in 0..bytes.len() {
            for bit in 0..8 {
                let mut flipped = bytes.clone();
                flipped[place] ^= 1 << bit;
                let error = Lut::decode(&flipped).expect_err("a flipped bit");
                let fits = match place {
                    0..12 => matches!(error, LutError::Foreign { offset, .. } if offset == place),
                    12..16 => matches!(error, LutError::Version { .. }),
                    16..24 => {
                        matches!(error, LutError::Truncated { .. } | LutError::TooLong { .. })
                    }
                    _ => matches!(error, LutError::Checksum { .. }),
                };
                assert!(fits, "byte {place} bit {bit}: {error}");
            }
        }
    }
}

#[test]
fn something_behind_the_end_is_refused() {
    let mut bytes = smallest().encode();
    bytes.push(0);
    let error = Lut::decode(&bytes).unwrap_err();
    assert!(matches!(error, LutError::TooLong { .. }), "{error}");
    assert!(error.to_string().ends_with("found 1 more bytes"), "{error}");
}

#[test]
fn foreign_files_are_refused() {
    for (file, place) in [
        (b"\x89PNG\r\n\x1a\n rest of a picture".as_slice(), 1),
        (b"altitude_km,pressure_hpa\n", 0),
        (b"\0", 0),
        // The same file with its line ends converted.
        (b"\x89UTMLUT\n\x1a\n\0\x01\0\0\0", 7),
    ] {
        match Lut::decode(file) {
            Err(LutError::Foreign { offset, .. }) => assert_eq!(offset, place),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn other_versions_are_refused() {
    for version in [0_u32, 2, u32::MAX] {
        let mut bytes = smallest().encode();
        bytes[12..16].copy_from_slice(&version.to_le_bytes());
        let error = Lut::decode(&bytes).unwrap_err();
        assert!(matches!(error, LutError::Version { expected: 1, found } if found == version));
    }
}

#[test]
fn absurd_sizes_take_no_memory() {
    for (header, values) in [(u32::MAX, u32::MAX), (0, u32::MAX), (u32::MAX, 0)] {
        let mut bytes = MAGIC.to_vec();
        for n in [VERSION, header, values] {
            bytes.extend(n.to_le_bytes());
        }
        bytes.extend([0; 64]);
        let error = Lut::decode(&bytes).unwrap_err();
        assert!(matches!(error, LutError::Truncated { expected, .. } if expected > 1 << 31));
    }
    // Axes that multiply to more than any file holds.
    let long: Vec<f64> = (0..70_000).map(f64::from).collect();
    let text = smallest_header();
    let long = serde_json::to_string(&long).unwrap();
    let text = text
        .replacen("[0.0,30.0]", &long, 1)
        .replacen("[0.0,92.0]", &long, 1);
    let error = Lut::decode(&file_with(&text, &[])).unwrap_err();
    assert!(
        matches!(
            error,
            LutError::TooLarge {
                shape: [70_000, 2, 70_000]
            }
        ),
        "{error}"
    );
}

#[test]
fn a_header_that_is_no_json_is_refused() {
    let deep = "[".repeat(100_000);
    for header in ["", "{", "null", "[1]", "{}", "\u{0}", deep.as_str()] {
        let error = Lut::decode(&file_with(header, &[1.0])).unwrap_err();
        assert!(
            matches!(error, LutError::Header(_)),
            "{header:.20}: {error}"
        );
        assert!(error.to_string().contains("line 1 column"), "{error}");
    }
}

#[test]
fn a_header_with_a_right_checksum_is_still_checked() {
    let message = |from, to| refused_header(from, to).to_string();
    for (from, to, words) in [
        // Not readable as what it should be.
        (
            "\"km\",\"nodes\":[0.0,30.0]",
            "\"km\",\"nodes\":[30.0,0.0]",
            "ascending",
        ),
        (
            "\"km\",\"nodes\":[0.0,30.0]",
            "\"km\",\"nodes\":[]",
            "at least 1 node",
        ),
        ("log-linear", "cubic", "report-lagrange"),
        ("perez-spherical", "hosek", "perez-report"),
        ("\"engine\":", "\"motor\":", "motor"),
        ("\"median\":0.25", "\"median\":null", "null"),
        // Readable, and wrong.
        (
            "\"unit\":\"km\"",
            "\"unit\":\"m\"",
            "altitude_km: expected the unit km",
        ),
        (
            "\"Y\",\"x\",\"y\"",
            "\"x\",\"y\",\"Y\"",
            "channels: expected Y x y",
        ),
        (
            "\"zenith\",\"A\"",
            "\"A\",\"zenith\"",
            "terms: expected zenith A B C D E",
        ),
        (
            "\"turbidity\":[1.0,8.0]",
            "\"turbidity\":[0.5,8.0]",
            "within 1 to 8, found 0.5 to 8",
        ),
    ] {
        let message = message(from, to);
        assert!(message.contains(words), "{from} -> {to}: {message}");
        assert!(message.starts_with("header"), "{message}");
    }
}

#[test]
fn values_must_be_as_many_as_the_axes_say_and_finite() {
    let lut = smallest();
    for count in [0, 143] {
        let error = Lut::decode(&file_with(&smallest_header(), &lut.data()[..count])).unwrap_err();
        assert!(
            matches!(error, LutError::Shape { expected: 144, found } if found == count),
            "{error}"
        );
    }
    for odd in [1, 2, 3, 575, 577] {
        let error = Lut::decode(&file_around(&smallest_header(), &vec![0; odd])).unwrap_err();
        assert!(matches!(error, LutError::Shape { .. }), "{error}");
    }
    let in_16_bits = smallest_header().replacen("\"f32\"", "\"linear16\"", 1);
    for odd in [0, 1, 100, 143, 144, 431, 433] {
        let error = Lut::decode(&file_around(&in_16_bits, &vec![0; odd])).unwrap_err();
        assert!(
            matches!(error, LutError::Shape { expected: 144, .. }),
            "{error}"
        );
    }
    assert!(Lut::decode(&file_around(&in_16_bits, &[0; 432])).is_ok());
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut data = vec![0; 432];
        data[8..12].copy_from_slice(&bad.to_le_bytes());
        let error = Lut::decode(&file_around(&in_16_bits, &data)).unwrap_err();
        assert!(
            matches!(error, LutError::NotFinite { index: 1, .. }),
            "{error}"
        );
        let mut values = lut.data().to_vec();
        values[77] = bad;
        let error = Lut::decode(&file_with(&smallest_header(), &values)).unwrap_err();
        assert!(
            matches!(error, LutError::NotFinite { index: 77, .. }),
            "{error}"
        );
    }
    let mut values: Vec<f64> = lut.data().iter().map(|v| f64::from(*v)).collect();
    assert_eq!(Lut::from_f64(lut.header().clone(), &values).unwrap(), lut);
    values[3] = 1e39;
    let error = Lut::from_f64(lut.header().clone(), &values).unwrap_err();
    assert!(
        matches!(error, LutError::NotFinite { index: 3, .. }),
        "{error}"
    );
}

#[test]
fn the_csv_has_the_layout_of_appendix_a() {
    let csv = report_grid().to_csv_string();
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(
        rows[0].join(","),
        "reference_altitude_km,turbidity,sun_zenith_deg,sun_azimuth_deg,\
         A_Y,B_Y,C_Y,D_Y,E_Y,A_x,B_x,C_x,D_x,E_x,A_y,B_y,C_y,D_y,E_y,\
         zenith_Y_cd_m2,zenith_x,zenith_y"
    );
    assert_eq!(rows.len(), 1 + 75);
    assert!(rows.iter().all(|row| row.len() == rows[0].len()));
    let suns: Vec<String> = rows[1..6].iter().map(|row| row[2..4].join(" ")).collect();
    assert_eq!(suns, ["90 90", "45 90", "0 0", "45 270", "90 270"]);
    assert_eq!(rows[6][..2].join(" "), "0 4.5");
    assert_eq!(rows[75][..4].join(" "), "30 8 90 270");
    // Row 3 is the first node: value i is i/8, the zenith the first of each channel.
    let numbers: Vec<f64> = rows[3][4..]
        .iter()
        .map(|cell| cell.parse().unwrap())
        .collect();
    let places = [1, 2, 3, 4, 5, 7, 8, 9, 10, 11, 13, 14, 15, 16, 17, 0, 6, 12];
    assert_eq!(numbers, places.map(|i| f64::from(i) / 8.0));

    let csv = smallest().to_csv_string();
    assert_eq!(csv.lines().count(), 1 + 8);
    assert!(csv.lines().nth(2).unwrap().starts_with("0,1,92,,"), "{csv}");
}

/// Ascending values from steps.
fn nodes(start: f64, steps: &[f64]) -> Vec<f64> {
    steps
        .iter()
        .scan(start, |at, step| {
            *at += step;
            Some(*at)
        })
        .collect()
}

prop_compose! {
    fn any_table()(
        form in prop::sample::select(Form::ALL.to_vec()),
        storage in prop::sample::select(vec![Storage::F32, Storage::Linear16]),
        rule in prop::sample::select(Interpolation::ALL.to_vec()),
        altitude in vec(1e-3..9.0_f64, 2..5),
        turbidity in vec(1e-3..9.0_f64, 2..4),
        sun in vec(1e-3..9.0_f64, 2..5),
        name in ".{0,20}",
        number in prop::num::f64::NORMAL,
        median in prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL,
    )(
        values in vec(
            prop::num::f32::NORMAL | prop::num::f32::SUBNORMAL | prop::num::f32::ZERO,
            altitude.len() * turbidity.len() * sun.len() * 3 * form.terms().len(),
        ),
        form in Just(form), storage in Just(storage), rule in Just(rule), altitude in Just(altitude),
        turbidity in Just(turbidity), sun in Just(sun), name in Just(name),
        number in Just(number), median in Just(median),
    ) -> Lut {
        let axes = [nodes(0.0, &altitude), nodes(1.0, &turbidity), nodes(-1.0, &sun)];
        let mut header = header(form, rule, axes.each_ref().map(Vec::as_slice));
        header.settings.insert(name.clone(), number.into());
        header.storage = storage;
        header.profile_name = name;
        header.fit.delta_e_2000.median = median;
        Lut::new(header, values).expect("a good table")
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    #[test]
    fn a_table_is_read_back_bit_for_bit(lut in any_table()) {
        let bytes = lut.encode();
        let read = Lut::decode(&bytes).expect("what was written");
        prop_assert_eq!(&read, &lut);
        // Equal values may differ in the sign of zero.
        let bits = |lut: &Lut| lut.data().iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(&read), bits(&lut));
        prop_assert_eq!(read.encode(), bytes);
    }

    #[test]
    fn a_damaged_table_is_refused(
        lut in any_table(),
        place in any::<prop::sample::Index>(),
        mask in 1..=u8::MAX,
        length in any::<prop::sample::Index>(),
    ) {
        let bytes = lut.encode();
        let mut damaged = bytes.clone();
        damaged[place.index(bytes.len())] ^= mask;
        prop_assert!(Lut::decode(&damaged).is_err());
        let cut = &bytes[..length.index(bytes.len())];
        let is_truncated = matches!(Lut::decode(cut), Err(LutError::Truncated { .. }));
        prop_assert!(is_truncated);
    }

    #[test]
    fn any_bytes_are_refused_without_a_panic(
        bytes in vec(any::<u8>(), 0..200),
        header in "\\PC{0,80}",
        values in vec(any::<f32>(), 0..20),
    ) {
        prop_assert!(Lut::decode(&bytes).is_err());
        prop_assert!(Lut::decode(&[&MAGIC, bytes.as_slice()].concat()).is_err());
        prop_assert!(Lut::decode(&file_with(&header, &values)).is_err());
    }

    #[test]
    fn a_value_lies_in_the_cell_that_the_axis_names(
        steps in vec(1e-3..9.0_f64, 2..40),
        share in 0.0..=1.0_f64,
    ) {
        let axis = Axis::new("km", nodes(-3.0, &steps)).unwrap();
        let [first, last] = axis.bounds();
        let value = (first + share * (last - first)).min(last);
        let cell = axis.cell_from_value(value).expect("inside");
        prop_assert!(axis.nodes()[cell.lower] <= value && value <= axis.nodes()[cell.lower + 1]);
        let back = axis.value_from_cell(cell).expect("a cell");
        prop_assert!((back - value).abs() < 1e-12 * (1.0 + last.abs()));
    }
}
