//! A frame of the runtime allocates nothing, and a direction neither.

use std::alloc::System;

use sky_core::direction::SkyDirection;
use sky_core::picture::Picture;
use sky_core::utm_sky::UtmSky;
use sky_eval::cases::conditions;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

#[test]
fn a_frame_allocates_nothing() {
    let sky = UtmSky::embedded().expect("the table");
    let conditions = conditions(3.7, 2.6, 71.0);
    let region = Region::new(ALLOCATOR);
    let picture = Picture::new(&sky, &conditions, 0.2).expect("inside the domain");
    let light = picture.color(SkyDirection::from_degrees(80.0, 20.0).unit_vector());
    let ground = picture.color(SkyDirection::from_degrees(100.0, 20.0).unit_vector());
    let change = region.change();
    assert!(light[0] > 0.0 && ground[0] > 0.0);
    assert_eq!(change.allocations, 0, "{change:?}");
}
