//! One GPU a process and one painter on it: a driver in software takes tens of seconds to compile the
//! programs of a renderer, and each device would do it again.

use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

use sky_core::utm_sky::UtmSky;
use sky_render::Painter;

pub(crate) static SKY: LazyLock<UtmSky> = LazyLock::new(|| UtmSky::embedded().expect("the table"));

static PAINTER: LazyLock<Mutex<Painter>> = LazyLock::new(|| {
    let painter = Painter::new(SKY.clone()).unwrap_or_else(|error| panic!("{error}"));
    Mutex::new(painter)
});

/// The painter of the embedded table; tests take turns.
pub(crate) fn painter() -> MutexGuard<'static, Painter> {
    PAINTER.lock().unwrap_or_else(PoisonError::into_inner)
}
