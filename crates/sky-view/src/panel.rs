//! The panel over the picture: everything that can be set, and what the frame costs.

use egui::{Color32, ComboBox, Grid, RichText, Slider, SliderClamping, Ui};
use sky_core::conditions::Domain;
use sky_core::quantity::{Angle, Length};
use sky_core::solar_position::{GeoPlace, SunPosition, UtcTime};
use sky_core::tonemap::Tone;
use sky_gpu::Tier;
use sky_render::shot::TIERS;

use crate::flight::{Edge, Flight, HazeWord, SPEEDS_KM_S, Sun};

/// Color of what is wrong.
const WARNING: Color32 = Color32::from_rgb(255, 120, 90);

/// What the keys do.
const KEYS: &str = "drag: look · W A S D, arrows: fly · E Q: up, down · Shift: faster · wheel: speed \
                    · P: pause · F12: screenshot · Tab: panel";

/// Everything that can be set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Controls {
    /// Place, look and speed.
    pub flight: Flight,
    /// The sun.
    pub sun: Sun,
    /// The word for the haze, and the number.
    pub haze: (HazeWord, f64),
    /// How the sky is drawn.
    pub tier: Tier,
    /// The tone curve.
    pub tone: Tone,
    /// Exposure value at ISO 100; `None` is automatic.
    pub ev100: Option<f32>,
    /// Whether the terrain is drawn.
    pub terrain: bool,
    /// Whether the air before it is.
    pub aerial: bool,
    /// Whether the sun's disc is drawn.
    pub sun_disc: bool,
    /// Stripes where the conditions are outside the table's domain, in place of the sky at its edge.
    pub stripes: bool,
    /// Whether flight and clock stand still.
    pub paused: bool,
    /// Whether the panel is shown.
    pub panel: bool,
    /// Whether a screenshot was asked for.
    pub screenshot: bool,
}

/// What the panel tells.
#[derive(Clone, Debug)]
pub struct Status {
    /// The GPU.
    pub gpu: String,
    /// The table's domain.
    pub domain: Domain,
    /// Where the sun stands, if it does.
    pub sun: Option<SunPosition>,
    /// What was stopped at the domain's edge.
    pub edges: [Option<Edge>; 3],
    /// What cannot be: haze, date.
    pub trouble: Option<String>,
    /// The exposure value in use.
    pub ev100: f32,
    /// Mean times of a frame, of the sky's update and of the terrain's mesh \[ms\].
    pub times_ms: [f64; 3],
    /// What came of the last screenshot.
    pub screenshot: Option<String>,
}

/// One of a list of values, by their names.
fn choice<T: Copy + PartialEq>(ui: &mut Ui, label: &str, value: &mut T, all: &[(T, &str)]) {
    let name = |v: &T| {
        all.iter()
            .find(|(one, _)| one == v)
            .map_or("", |(_, name)| name)
    };
    ui.label(label);
    ComboBox::from_id_salt(label)
        .selected_text(name(value))
        .show_ui(ui, |ui| {
            for (one, name) in all {
                ui.selectable_value(value, *one, *name);
            }
        });
    ui.end_row();
}

/// A slider that leaves a number beyond its ends as it is: what the table does not cover is said, not
/// mended.
fn open(slider: Slider<'_>) -> Slider<'_> {
    slider.clamping(SliderClamping::Never).max_decimals(3)
}

/// Draws the panel and takes what is set there.
pub fn show(context: &egui::Context, controls: &mut Controls, status: &Status) {
    warnings(context, status);
    if !controls.panel {
        return;
    }
    egui::Window::new("UTM sky")
        .default_pos([12.0, 12.0])
        .resizable(false)
        .show(context, |ui| {
            Grid::new("controls").num_columns(2).show(ui, |ui| {
                flight(ui, controls, status);
                sun(ui, controls, status);
                haze(ui, controls, status);
                picture(ui, controls, status);
            });
            ui.separator();
            ui.horizontal(|ui| {
                ui.checkbox(&mut controls.paused, "pause");
                controls.screenshot |= ui.button("screenshot").clicked();
            });
            if let Some(message) = &status.screenshot {
                ui.label(message);
            }
            let [frame, update, mesh] = status.times_ms;
            ui.label(format!(
                "frame {frame:.1} ms · sky update {update:.3} ms · terrain {mesh:.2} ms"
            ));
            ui.label(RichText::new(&status.gpu).weak());
            ui.label(RichText::new(KEYS).weak().small());
        });
}

/// What is beyond the table, over the picture even without the panel.
fn warnings(context: &egui::Context, status: &Status) {
    let edges = status.edges.iter().flatten();
    if status.trouble.is_none() && edges.clone().next().is_none() {
        return;
    }
    egui::Area::new(egui::Id::unique("warnings"))
        .order(egui::Order::Foreground)
        .anchor(egui::Align2::CENTER_BOTTOM, [0.0, -12.0])
        .show(context, |ui| {
            egui::Frame::popup(ui.style()).show(ui, |ui| {
                for Edge {
                    quantity,
                    asked,
                    edge,
                } in edges
                {
                    let text = format!(
                        "{quantity}: {asked:.2} is outside the table; the sky shown is that of {edge:.2}, its edge"
                    );
                    ui.label(RichText::new(text).color(WARNING).strong());
                }
                if let Some(trouble) = &status.trouble {
                    ui.label(RichText::new(trouble).color(WARNING).strong());
                }
            });
        });
}

fn flight(ui: &mut Ui, controls: &mut Controls, status: &Status) {
    let [low, high] = status.domain.altitude_km;
    ui.label("altitude [km]");
    ui.add(open(Slider::new(
        &mut controls.flight.altitude_km,
        low..=high,
    )));
    ui.end_row();
    if controls.flight.altitude_km >= high {
        ui.label("");
        ui.label(RichText::new("the table ends here").color(WARNING));
        ui.end_row();
    }
    ui.label("speed [km/s]");
    let [slowest, fastest] = SPEEDS_KM_S;
    ui.add(Slider::new(&mut controls.flight.speed_km_s, slowest..=fastest).logarithmic(true));
    ui.end_row();
    let [azimuth, elevation] = controls.flight.look_deg;
    ui.label("look");
    ui.label(format!("{azimuth:.0}° from north, {elevation:.0}° up"));
    ui.end_row();
}

fn sun(ui: &mut Ui, controls: &mut Controls, status: &Status) {
    ui.label("sun by");
    ui.horizontal(|ui| {
        let is_clock = matches!(controls.sun, Sun::Clock { .. });
        let shown = status.sun.unwrap_or(SunPosition {
            zenith: Angle::ZERO,
            azimuth: Angle::ZERO,
        });
        if ui.selectable_label(!is_clock, "angles").clicked() {
            controls.sun = Sun::Angles(shown);
        }
        if ui.selectable_label(is_clock, "date and place").clicked() && !is_clock {
            controls.sun = Sun::Clock {
                time: UtcTime {
                    year: 2025,
                    month: 6,
                    day: 21,
                    hours: 12.0,
                },
                place: GeoPlace {
                    latitude: Angle::from_degrees(47.26),
                    longitude: Angle::from_degrees(11.34),
                    altitude: Length::ZERO,
                },
                hours_per_s: 0.0,
            };
        }
    });
    ui.end_row();
    match &mut controls.sun {
        Sun::Angles(position) => {
            let mut degrees = [position.zenith.degrees(), position.azimuth.degrees()];
            for (value, (label, largest)) in degrees
                .iter_mut()
                .zip([("zenith [deg]", 110.0), ("azimuth [deg]", 360.0)])
            {
                ui.label(label);
                ui.add(open(Slider::new(value, 0.0..=largest)));
                ui.end_row();
            }
            *position = SunPosition {
                zenith: Angle::from_degrees(degrees[0]),
                azimuth: Angle::from_degrees(degrees[1]),
            };
        }
        Sun::Clock {
            time,
            place,
            hours_per_s,
        } => clock(ui, time, place, hours_per_s, status),
    }
}

fn clock(
    ui: &mut Ui,
    time: &mut UtcTime,
    place: &mut GeoPlace,
    hours_per_s: &mut f64,
    status: &Status,
) {
    ui.label("date");
    ui.horizontal(|ui| {
        ui.add(egui::DragValue::new(&mut time.year).range(1900..=2100));
        ui.add(egui::DragValue::new(&mut time.month).range(1..=12));
        ui.add(egui::DragValue::new(&mut time.day).range(1..=31));
    });
    ui.end_row();
    ui.label("time [h UTC]");
    // the clock may run past midnight; its days stay
    let days = (time.hours / 24.0).floor();
    let mut hour = time.hours - 24.0 * days;
    ui.add(Slider::new(&mut hour, 0.0..=24.0).max_decimals(2));
    time.hours = 24.0 * days + hour;
    ui.end_row();
    ui.label("hours a second");
    ui.add(
        Slider::new(hours_per_s, -2.0..=2.0)
            .logarithmic(true)
            .smallest_positive(0.001),
    );
    ui.end_row();
    ui.label("latitude, longitude");
    ui.horizontal(|ui| {
        for (angle, most) in [(&mut place.latitude, 90.0), (&mut place.longitude, 180.0)] {
            let mut degrees = angle.degrees();
            ui.add(
                egui::DragValue::new(&mut degrees)
                    .range(-most..=most)
                    .max_decimals(3)
                    .speed(0.2)
                    .suffix("°"),
            );
            *angle = Angle::from_degrees(degrees);
        }
    });
    ui.end_row();
    if let Some(sun) = status.sun {
        ui.label("sun");
        ui.label(format!(
            "{:.1}° from the zenith, azimuth {:.0}°",
            sun.zenith.degrees(),
            sun.azimuth.degrees()
        ));
        ui.end_row();
    }
}

fn haze(ui: &mut Ui, controls: &mut Controls, status: &Status) {
    let (word, value) = &mut controls.haze;
    let [clear, hazy] = status.domain.turbidity;
    let name = |word: HazeWord| {
        HazeWord::ALL
            .iter()
            .find(|(w, _)| *w == word)
            .map_or("", |(_, name)| name)
    };
    ui.label("haze");
    ComboBox::from_id_salt("haze")
        .selected_text(name(*word))
        .show_ui(ui, |ui| {
            for (other, name) in HazeWord::ALL {
                if ui.selectable_label(*word == other, name).clicked() {
                    // the same haze in the other word
                    let turbidity = word.haze(*value).turbidity().unwrap_or(clear);
                    (*word, *value) = (other, other.value(turbidity));
                }
            }
        });
    ui.end_row();
    ui.label("");
    let (a, b) = (word.value(clear), word.value(hazy));
    let slider = open(Slider::new(value, a.min(b)..=a.max(b)));
    ui.add(slider.logarithmic(*word == HazeWord::VisualRange));
    ui.end_row();
}

fn picture(ui: &mut Ui, controls: &mut Controls, status: &Status) {
    choice(ui, "tier", &mut controls.tier, &TIERS);
    choice(ui, "tone curve", &mut controls.tone, &Tone::ALL);
    ui.label("exposure [EV100]");
    ui.horizontal(|ui| {
        let mut is_auto = controls.ev100.is_none();
        ui.checkbox(&mut is_auto, "auto");
        let mut ev100 = controls.ev100.unwrap_or(status.ev100);
        ui.add_enabled(!is_auto, Slider::new(&mut ev100, -6.0..=18.0));
        controls.ev100 = (!is_auto).then_some(ev100);
    });
    ui.end_row();
    ui.label("draw");
    ui.horizontal(|ui| {
        ui.checkbox(&mut controls.terrain, "terrain");
        ui.checkbox(&mut controls.aerial, "air before it");
        ui.checkbox(&mut controls.sun_disc, "sun");
    });
    ui.end_row();
    ui.label("outside the table");
    ui.checkbox(&mut controls.stripes, "stripes for the sky");
    ui.end_row();
}
