//! Any bytes are a look-up table or refused; what is read is written back and can be asked.
//!
//! The checksum would keep a fuzzer out, so the bytes are tried with a right one too.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sky_core::direction::SkyDirection;
use sky_core::lut::Lut;
use sky_core::quantity::{Angle, Length};
use sky_core::conditions::Conditions;
use sky_science::table_sky::TableSky;

/// CRC-64/XZ, bit by bit.
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

fn check(bytes: &[u8]) {
    let Ok(lut) = Lut::decode(bytes) else { return };
    let again = Lut::decode(&lut.encode()).expect("what was written is read");
    assert_eq!(again.encode(), lut.encode());
    let domain = lut.header().domain;
    let Ok(sky) = TableSky::new(lut) else { return };
    let conditions = Conditions {
        observer_altitude: Length::from_km(domain.altitude_km[0]),
        turbidity: domain.turbidity[1],
        sun_zenith: Angle::from_degrees(domain.sun_zenith_deg[0]),
    };
    if let Ok(frame) = sky.frame(&conditions) {
        let _ = frame.yxy(&SkyDirection::from_degrees(40.0, 10.0));
    }
}

fuzz_target!(|bytes: &[u8]| {
    check(bytes);
    if let Some(end) = bytes.len().checked_sub(8) {
        let mut mended = bytes[..end].to_vec();
        mended.extend(crc(&bytes[..end]).to_le_bytes());
        check(&mended);
    }
});
