//! A picture's pixels, and the bytes of its file.

use std::io::Cursor;

use anyhow::Result;
use exr::prelude::{Image, SpecificChannels, Text, Vec2, WritableImage as _};
use image::{ExtendedColorType, ImageEncoder as _};
use sky_core::tonemap::{Tone, dither, encoded, tone_mapped};

/// A picture: 8-bit sRGB, or linear light.
#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    /// Red, green, blue.
    Srgb8(Vec<u8>),
    /// Linear sRGB \[cd·m⁻²\].
    Linear(Vec<f32>),
}

/// Numbers as a GPU takes them.
#[must_use]
pub fn bytes_of(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// Numbers as a GPU gives them.
#[must_use]
pub fn floats_of(bytes: &[u8]) -> Vec<f32> {
    bytes
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect()
}

/// Light as a picture for a tone curve; `None` leaves it linear. `width` is that of the picture.
#[must_use]
pub fn developed(lights: Vec<[f32; 3]>, width: u32, tone: Option<Tone>, exposure: f32) -> Pixels {
    match tone {
        None => Pixels::Linear(lights.into_iter().flatten().collect()),
        Some(tone) => Pixels::Srgb8(
            lights
                .into_iter()
                .enumerate()
                .flat_map(|(i, light)| {
                    let i = u32::try_from(i).unwrap_or(0);
                    let noise = dither(i % width, i / width) / 255.0;
                    tone_mapped(light.map(|c| c * exposure), tone).map(|c| byte(encoded(c) + noise))
                })
                .collect(),
        ),
    }
}

/// A share of 1 as a byte.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to 0..255"
)]
pub fn byte(value: f32) -> u8 {
    (value * 255.0).round().clamp(0.0, 255.0) as u8
}

/// The same with a comment in ASCII for those who open the file.
///
/// # Errors
/// When the picture cannot be encoded.
pub fn file_bytes_with_comment(
    pixels: &Pixels,
    [width, height]: [u32; 2],
    comment: &str,
) -> Result<Vec<u8>> {
    let mut out = Cursor::new(Vec::new());
    match pixels {
        Pixels::Srgb8(bytes) => {
            let mut encoder = png::Encoder::new(&mut out, width, height);
            encoder.set_color(png::ColorType::Rgb);
            encoder.set_depth(png::BitDepth::Eight);
            encoder.add_text_chunk("Comment".to_owned(), comment.to_owned())?;
            encoder.write_header()?.write_image_data(bytes)?;
        }
        Pixels::Linear(values) => {
            let size = [width, height].map(|side| side as usize);
            let channels = SpecificChannels::rgb(|place: Vec2<usize>| {
                let first = 3 * (place.y() * size[0] + place.x());
                (values[first], values[first + 1], values[first + 2])
            });
            let mut image = Image::from_channels((size[0], size[1]), channels);
            image.layer_data.attributes.comments = Text::new_or_none(comment);
            image.write().to_buffered(&mut out)?;
        }
    }
    Ok(out.into_inner())
}

/// The bytes of a PNG or EXR file.
///
/// # Errors
/// When the picture cannot be encoded.
pub fn file_bytes(pixels: &Pixels, [width, height]: [u32; 2]) -> Result<Vec<u8>> {
    let mut out = Cursor::new(Vec::new());
    match pixels {
        Pixels::Srgb8(bytes) => image::codecs::png::PngEncoder::new(&mut out).write_image(
            bytes,
            width,
            height,
            ExtendedColorType::Rgb8,
        )?,
        Pixels::Linear(values) => {
            let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_ne_bytes()).collect();
            image::codecs::openexr::OpenExrEncoder::new(&mut out).write_image(
                &bytes,
                width,
                height,
                ExtendedColorType::Rgb32F,
            )?;
        }
    }
    Ok(out.into_inner())
}
