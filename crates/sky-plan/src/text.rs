//! A plan for people.

use std::fmt::Write as _;

use anyhow::Result;

use crate::plan::PlannedAerial;
use crate::planning::Planned;

impl Planned {
    /// The choices as text.
    ///
    /// # Errors
    /// Never: a text takes everything.
    pub fn report(&self) -> Result<String> {
        let plan = &self.plan;
        let found = &plan.expected;
        let mut out = String::new();
        writeln!(
            out,
            "{}: {} bytes, CIEDE2000 p95 {:.2} of {}, luminance p95 {:.2} % of {} %",
            plan.scene,
            found.bytes,
            found.delta_e_p95,
            plan.tolerance.delta_e,
            100.0 * found.luminance_p95,
            100.0 * plan.tolerance.luminance,
        )?;
        self.axes(&mut out)?;
        writeln!(out, "products        {}", plan.terms.join(" "))?;
        writeln!(
            out,
            "air             {}; every {} nm",
            plan.constituents.join(" "),
            plan.wavelength_step_nm
        )?;
        writeln!(out, "tier            {}", plan.tier.name())?;
        writeln!(
            out,
            "aerial          {}",
            match plan.aerial {
                PlannedAerial::None => "none: the air before the farthest object cannot be seen",
                PlannedAerial::Default => "default",
            }
        )?;
        self.choices(&mut out)?;
        Ok(out)
    }

    /// Ranges and nodes.
    fn axes(&self, out: &mut String) -> Result<()> {
        let plan = &self.plan;
        for (name, domain, nodes) in [
            (
                "altitude km",
                plan.domain.altitude_km,
                &plan.grid.altitude_km,
            ),
            ("turbidity", plan.domain.turbidity, &plan.grid.turbidity),
            (
                "sun zenith deg",
                plan.domain.sun_zenith_deg,
                &plan.grid.sun_zenith_deg,
            ),
        ] {
            let nodes: Vec<String> = nodes.iter().map(f64::to_string).collect();
            writeln!(
                out,
                "{name:<15} {} to {}: nodes {}",
                domain[0],
                domain[1],
                nodes.join(" ")
            )?;
        }
        Ok(())
    }

    /// What each choice saves and adds, what would break first, and the default table beside it.
    fn choices(&self, out: &mut String) -> Result<()> {
        writeln!(
            out,
            "\n{:<52} {:>8} {:>8} {:>7} {:>8} {:>8}",
            "choice", "saves B", "ns/pixel", "bake s", "adds dE", "adds Y"
        )?;
        for row in &self.rows {
            let bytes = row.bytes.map_or("-".to_owned(), |b| b.to_string());
            let seconds = row.seconds.map_or("-".to_owned(), |s| format!("{s:.1}"));
            writeln!(
                out,
                "{:<52} {bytes:>8} {:>8} {seconds:>7} {:>8.3} {:>6.2} %",
                row.what,
                // the products that are left out are zeros: a pixel takes the same time
                row.bytes.map_or("-", |_| "0"),
                row.delta_e,
                100.0 * row.luminance
            )?;
        }
        if let Some(first) = self.removals.first() {
            writeln!(
                out,
                "first to break: {}: {} bytes, CIEDE2000 p95 {:.2}, luminance p95 {:.2} % (aim: {:.2}, {:.2} %)",
                first.what,
                first.bytes,
                first.delta_e,
                100.0 * first.luminance,
                self.aim.delta_e,
                100.0 * self.aim.luminance
            )?;
        }
        if let Some((bytes, delta_e, luminance)) = self.default {
            writeln!(
                out,
                "the default table in its own air: {bytes} bytes, CIEDE2000 p95 {delta_e:.2}, luminance p95 {:.2} %",
                100.0 * luminance
            )?;
        }
        Ok(())
    }
}
