//! The same haze said in four ways; and a haze that the table does not know, told in the word that was
//! used, and clamped where the caller asks for it.
#![expect(clippy::print_stdout, reason = "an example shows what it finds")]

use sky_core::{Angle, Conditions, Haze, Length, UtmSky};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sky = UtmSky::embedded()?;
    let (ground, sun) = (Length::ZERO, Angle::from_degrees(30.0));
    let (beta, alpha) = (0.06, 1.3);
    for haze in [
        Haze::Turbidity(2.0),
        Haze::OpticalDepth500(0.14344),
        Haze::Angstrom { beta, alpha },
        Haze::VisualRange(Length::from_km(32.0)),
    ] {
        println!("{haze:?}: turbidity {:.3}", haze.turbidity()?);
        sky.frame(&Conditions::new(ground, haze, sun)?)?;
    }
    let haze = Haze::VisualRange(Length::from_km(2.0));
    let asked = Conditions::new(ground, haze, sun)?;
    let nearest = sky.domain().nearest(&asked)?;
    for change in nearest.changes() {
        println!("{}: the nearest is shown", change.in_words_of(haze));
    }
    sky.frame(&nearest.conditions)?;
    Ok(())
}
