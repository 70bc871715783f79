//! `utm-sky export-shaders`: the shaders in another engine's language, with the table as plain floats.

use std::fmt::Write as _;
use std::path::PathBuf;

use anyhow::{Result, anyhow};
use clap::{Args, ValueEnum};
use naga::back::{glsl, hlsl, msl, spv};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Module, ShaderStage};
use sky_core::lut::Lut;
use sky_gpu::shader;

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

/// Runs the command.
///
/// # Errors
/// When the table cannot be read or a file cannot be written.
pub fn run(args: &ExportShadersArgs) -> Result<()> {
    let lut = load(&args.lut)?;
    create_directory(&args.out)?;
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    for program in shader::PROGRAMS {
        let name = program.0;
        files.extend(translate(name, &shader::text(program, false), args.target)?);
        let linear = format!("{name}_linear");
        files.extend(translate(
            &linear,
            &shader::text(program, true),
            args.target,
        )?);
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
    out.push_str(
        "   Blend linearly in altitude [km], in ln(T - 0.7) of the turbidity and in the sun's zenith\n\
         \x20  angle [deg]; the blended terms are the coefficients of SkyUniform. */\n",
    );
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
