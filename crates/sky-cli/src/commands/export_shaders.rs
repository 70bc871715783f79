//! `utm-sky export-shaders`: the shaders in another engine's language, with the table as plain floats.

use std::fmt::Write as _;
use std::path::PathBuf;

use anyhow::{Result, anyhow};
use clap::{Args, ValueEnum};
use naga::back::{glsl, hlsl, msl, spv};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Module, ShaderStage};
use sky_core::lut::{Form, Interpolation, Lut};
use sky_gpu::{Output, shader};

use crate::args::{LutSource, lut_source};
use crate::io::files::{OutputFile, create_directory};
use crate::io::lut::load;

/// A language that shaders are translated to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ShaderTarget {
    /// GLSL 4.50
    Glsl,
    /// GLSL ES 3.00 (WebGL2)
    GlslEs,
    /// HLSL, shader model 5.1
    Hlsl,
    /// Metal 2.0
    Msl,
    /// SPIR-V 1.3
    Spirv,
}

/// `utm-sky export-shaders`.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  utm-sky export-shaders --target glsl-es --out shaders-es

Writes every entry point, the table as plain floats (sky.bin) and a header that documents it (sky.h).")]
pub struct ExportShadersArgs {
    /// Language
    #[arg(long, value_enum)]
    pub target: ShaderTarget,
    /// Look-up table: a .utmlut file, a plan (.toml), which is baked first, or the built-in one
    #[arg(long, value_name = "FILE|embedded", default_value = "embedded", value_parser = lut_source)]
    pub lut: LutSource,
    /// Directory
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// What the names of a program's files end in, for each of [`Output::ALL`].
const ENDINGS: [&str; 4] = ["_linear", "", "_hdr10", "_scrgb"];

/// Runs the command.
///
/// # Errors
/// When the table cannot be read or a file cannot be written.
pub fn run(args: &ExportShadersArgs) -> Result<()> {
    let lut = load(&args.lut)?;
    create_directory(&args.out)?;
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    for program in shader::PROGRAMS {
        if args.target == ShaderTarget::GlslEs && !program.in_glsl_es {
            continue;
        }
        for (output, ending) in Output::ALL.into_iter().zip(ENDINGS) {
            let name = format!("{}{ending}", program.name);
            files.extend(translate(
                &name,
                &shader::text(program, output),
                args.target,
            )?);
        }
    }
    let floats = lut.data().iter().flat_map(|v| v.to_le_bytes()).collect();
    files.push(("sky.bin".to_owned(), floats));
    files.push(("sky.h".to_owned(), header(&lut)?.into_bytes()));
    for (name, bytes) in files {
        OutputFile::create(&args.out.join(name))?.commit(&bytes)?;
    }
    Ok(())
}

/// A program's entry points in a language: names and bytes of files.
///
/// # Errors
/// When the text is no valid shader or the language cannot express it.
pub fn translate(name: &str, text: &str, target: ShaderTarget) -> Result<Vec<(String, Vec<u8>)>> {
    let module = naga::front::wgsl::parse_str(text)
        .map_err(|e| anyhow!("{name}.wgsl: {}", e.emit_to_string(text)))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|e| anyhow!("{name}.wgsl: {}", e.emit_to_string(text)))?;
    match target {
        ShaderTarget::Glsl => glsl_files(name, &module, &info, glsl::Version::Desktop(450)),
        ShaderTarget::GlslEs => {
            let version = glsl::Version::Embedded {
                version: 300,
                is_webgl: true,
            };
            glsl_files(name, &module, &info, version)
        }
        ShaderTarget::Hlsl => {
            let mut out = String::new();
            let options = hlsl::Options {
                fake_missing_bindings: true,
                ..hlsl::Options::default()
            };
            let pipeline = hlsl::PipelineOptions::default();
            hlsl::Writer::new(&mut out, &options, &pipeline).write(&module, &info, None)?;
            Ok(vec![(format!("{name}.hlsl"), out.into_bytes())])
        }
        ShaderTarget::Msl => {
            let (out, _) = msl::write_string(
                &module,
                &info,
                &msl::Options {
                    lang_version: (2, 0),
                    fake_missing_bindings: true,
                    ..msl::Options::default()
                },
                &msl::PipelineOptions::default(),
            )?;
            Ok(vec![(format!("{name}.metal"), out.into_bytes())])
        }
        ShaderTarget::Spirv => {
            let words = spv::write_vec(&module, &info, &spv::Options::default(), None)?;
            let bytes = words.iter().flat_map(|w| w.to_le_bytes()).collect();
            Ok(vec![(format!("{name}.spv"), bytes)])
        }
    }
}

fn glsl_files(
    name: &str,
    module: &Module,
    info: &ModuleInfo,
    version: glsl::Version,
) -> Result<Vec<(String, Vec<u8>)>> {
    module
        .entry_points
        .iter()
        .map(|entry| {
            let mut out = String::new();
            let options = glsl::Options {
                version,
                ..glsl::Options::default()
            };
            let pipeline = glsl::PipelineOptions {
                shader_stage: entry.stage,
                entry_point: entry.name.clone(),
                multiview: None,
            };
            glsl::Writer::new(
                &mut out,
                module,
                info,
                &options,
                &pipeline,
                naga::proc::BoundsCheckPolicies::default(),
            )?
            .write()?;
            let stage = if entry.stage == ShaderStage::Vertex {
                "vert"
            } else {
                "frag"
            };
            Ok((format!("{name}.{}.{stage}", entry.name), out.into_bytes()))
        })
        .collect()
}

/// How a table is read between its nodes.
const fn blending(form: Form, interpolation: Interpolation) -> &'static str {
    match (form, interpolation) {
        (Form::Extended, _) => {
            "Blend linearly in altitude [km], in ln(T - 0.7) of the turbidity and in the sun's\n   zenith \
             angle [deg]; the blended terms are the coefficients of SkyUniform."
        }
        (_, Interpolation::LogLinear) => {
            "The terms of a node are Perez's formula; they do not blend. Blend ln Y, x and y of the\n   \
             nodes' lights: linearly in altitude [km], in ln(T - 0.7) of the turbidity and in the\n   \
             sun's zenith angle [deg]."
        }
        (_, Interpolation::ReportLagrange) => {
            "The terms of a node are Perez's formula; they do not blend. Blend linear sRGB of the\n   \
             nodes' lights: by Lagrange's weights over the four nearest altitudes [km], linearly in\n   \
             the turbidity T and in the sun's zenith angle [deg]."
        }
    }
}

/// A C header that documents `sky.bin`.
fn header(lut: &Lut) -> Result<String> {
    let h = lut.header();
    let mut out = String::from(
        "/* The table of the UTM sky model, as little-endian 32-bit floats in sky.bin.\n\
         \x20  Order: [altitude][turbidity][sun zenith][channel][term], the last fastest.\n",
    );
    writeln!(
        out,
        "   Channels: {}. Form: {}.",
        h.channels.join(", "),
        h.form.name()
    )?;
    writeln!(out, "   Terms: {}.", h.terms.join(", "))?;
    writeln!(out, "   {} */", blending(h.form, h.interpolation))?;
    for (name, axis) in [
        ("ALTITUDE_KM", &h.altitude_km),
        ("TURBIDITY", &h.turbidity),
        ("SUN_ZENITH_DEG", &h.sun_zenith_deg),
    ] {
        let nodes: Vec<String> = axis.nodes().iter().map(|n| format!("{n:?}f")).collect();
        writeln!(
            out,
            "static const float UTM_SKY_{name}[{}] = {{{}}};",
            nodes.len(),
            nodes.join(", ")
        )?;
    }
    writeln!(
        out,
        "enum {{ UTM_SKY_VALUES_PER_NODE = {} }};",
        h.values_per_node()
    )?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every form was said to blend in ln(T - 0.7) to coefficients of `SkyUniform`.
    #[test]
    fn b13_the_header_says_how_this_form_blends() {
        let extended = blending(Form::Extended, Interpolation::LogLinear);
        assert!(extended.contains("ln(T - 0.7)") && extended.contains("SkyUniform"));
        let spherical = blending(Form::PerezSpherical, Interpolation::LogLinear);
        assert!(spherical.contains("ln(T - 0.7)") && !spherical.contains("SkyUniform"));
        let report = blending(Form::PerezReport, Interpolation::ReportLagrange);
        assert!(report.contains("Lagrange") && !report.contains("ln(T"));
    }
}
