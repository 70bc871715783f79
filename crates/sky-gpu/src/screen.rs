//! A window's pictures: the device that draws them, their size, and what to do when they are lost.
//!
//! The counterpart of [`crate::headless`]. The window itself is the caller's, from winit or any other
//! library. Out of scope: more than one window on a device.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use thiserror::Error;
use wgpu::CurrentSurfaceTexture;

use crate::headless::Headless;

/// What can go wrong with a window's pictures.
#[derive(Debug, Error)]
pub enum ScreenError {
    /// The window cannot be drawn to.
    #[error("window: expected one that a GPU can draw to, found none ({0})")]
    Surface(#[from] wgpu::CreateSurfaceError),
    /// No driver for the window.
    #[error(
        "GPU: expected a Vulkan, Metal or Direct3D 12 driver for the window, found none ({0}); on \
         Debian or Ubuntu install mesa-vulkan-drivers for a software one"
    )]
    NoAdapter(#[from] wgpu::RequestAdapterError),
    /// No GPU of that name.
    #[error("GPU: expected one of {available}, found {wanted:?}")]
    UnknownAdapter {
        /// The name asked for.
        wanted: String,
        /// The names there are, for the window.
        available: String,
    },
    /// A driver that gives no device.
    #[error("GPU: expected a device, found none ({0})")]
    NoDevice(#[from] wgpu::RequestDeviceError),
    /// No format for the window.
    #[error("GPU: expected a format for the window, found none on {0}")]
    NoFormat(String),
    /// The device or the window's surface is gone. A new [`Screen`] and all that is on the device
    /// must be made.
    #[error("GPU: expected the next picture, found a lost device or surface")]
    Lost,
    /// The device refused what it was told to do.
    #[error("GPU: {0}")]
    Refused(String),
}

/// A device and the surface of a window. Draws with vertical synchronization.
#[derive(Debug)]
pub struct Screen {
    /// Device and queue.
    pub gpu: Headless,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    largest_side: u32,
    is_lost: Arc<AtomicBool>,
    refused: Arc<Mutex<Option<String>>>,
    must_configure: bool,
}

impl Screen {
    /// Opens the fastest GPU that can draw to a window, or the one whose name has `adapter` in it.
    ///
    /// # Errors
    /// When there is no such GPU, or the window cannot be drawn to.
    pub fn new(
        window: impl Into<wgpu::SurfaceTarget<'static>>,
        size: [u32; 2],
        adapter: Option<&str>,
    ) -> Result<Self, ScreenError> {
        let mut wanted = wgpu::InstanceDescriptor::new_without_display_handle();
        wanted.backends = wgpu::Backends::PRIMARY;
        let instance = wgpu::Instance::new(wanted);
        let surface = instance.create_surface(window)?;
        let adapter = match adapter {
            Some(name) => named(&instance, &surface, name)?,
            None => pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
                power_preference: wgpu::PowerPreference::HighPerformance,
                compatible_surface: Some(&surface),
                ..wgpu::RequestAdapterOptions::default()
            }))?,
        };
        let limits = adapter.limits();
        let (device, queue) =
            pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
                label: Some("sky"),
                required_limits:
                    wgpu::Limits::downlevel_webgl2_defaults().using_resolution(limits.clone()),
                ..wgpu::DeviceDescriptor::default()
            }))?;
        let is_lost = Arc::new(AtomicBool::new(false));
        let refused = Arc::new(Mutex::new(None));
        let flag = Arc::clone(&is_lost);
        device.set_device_lost_callback(move |_, _| flag.store(true, Ordering::Relaxed));
        let first = Arc::clone(&refused);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let mut first = first.lock().unwrap_or_else(PoisonError::into_inner);
            first.get_or_insert_with(|| error.to_string());
        }));
        let info = adapter.get_info();
        let [width, height] = size;
        let mut config = surface
            .get_default_config(&adapter, width.max(1), height.max(1))
            .ok_or_else(|| ScreenError::NoFormat(info.name.clone()))?;
        // the sky encodes by itself, with noise that fits 8 bits
        let formats = surface.get_capabilities(&adapter).formats;
        let plain = [
            wgpu::TextureFormat::Bgra8Unorm,
            wgpu::TextureFormat::Rgba8Unorm,
        ];
        if let Some(format) = plain.into_iter().find(|f| formats.contains(f)) {
            config.format = format;
        }
        config.present_mode = wgpu::PresentMode::Fifo;
        let mut screen = Self {
            gpu: Headless {
                device,
                queue,
                info,
                timestamp_ns: None,
            },
            surface,
            config,
            largest_side: limits.max_texture_dimension_2d,
            is_lost,
            refused,
            must_configure: true,
        };
        screen.resize(size);
        Ok(screen)
    }

    /// Format of the window's pictures.
    #[must_use]
    pub const fn format(&self) -> wgpu::TextureFormat {
        self.config.format
    }

    /// Size of the pictures; 0 while the window is minimized.
    #[must_use]
    pub const fn size(&self) -> [u32; 2] {
        [self.config.width, self.config.height]
    }

    /// Width over height; 1 while the window is minimized.
    #[must_use]
    pub fn aspect(&self) -> f32 {
        let side = |pixels| u16::try_from(pixels).map_or(65535.0, f32::from).max(1.0);
        side(self.config.width) / side(self.config.height)
    }

    /// Takes the window's new size.
    pub fn resize(&mut self, size: [u32; 2]) {
        let [width, height] = size.map(|side| side.min(self.largest_side));
        (self.config.width, self.config.height) = (width, height);
        self.must_configure = true;
    }

    /// The next picture, to be drawn to and given to [`Self::present`]. `None` when there is nothing
    /// to draw to now: the window is minimized or hidden, or the display is slow.
    ///
    /// # Errors
    /// [`ScreenError::Lost`] when device or surface are gone, [`ScreenError::Refused`] when the device
    /// refused something since the last picture.
    pub fn next_target(&mut self) -> Result<Option<wgpu::SurfaceTexture>, ScreenError> {
        self.check()?;
        if self.size().contains(&0) {
            return Ok(None);
        }
        // once as it is, once more after the surface has been told its size again
        for _ in 0..2 {
            if self.must_configure {
                self.must_configure = false;
                self.surface.configure(&self.gpu.device, &self.config);
                self.check()?;
            }
            match self.surface.get_current_texture() {
                CurrentSurfaceTexture::Success(texture) => return Ok(Some(texture)),
                CurrentSurfaceTexture::Suboptimal(texture) => {
                    self.must_configure = true;
                    return Ok(Some(texture));
                }
                CurrentSurfaceTexture::Outdated | CurrentSurfaceTexture::Lost => {
                    self.must_configure = true;
                }
                CurrentSurfaceTexture::Timeout | CurrentSurfaceTexture::Occluded => {
                    return Ok(None);
                }
                CurrentSurfaceTexture::Validation => self.check()?,
            }
        }
        Err(ScreenError::Lost)
    }

    /// Shows a texture that [`Self::next_target`] gave.
    pub fn present(&self, texture: wgpu::SurfaceTexture) {
        self.gpu.queue.present(texture);
    }

    fn check(&self) -> Result<(), ScreenError> {
        let is_lost = || self.is_lost.load(Ordering::Relaxed);
        if is_lost() {
            return Err(ScreenError::Lost);
        }
        let refused = self
            .refused
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        let Some(message) = refused else {
            return Ok(());
        };
        // a device that is going refuses everything before it says that it is gone
        let polled = self.gpu.device.poll(wgpu::PollType::Poll);
        Err(if is_lost() || polled.is_err() {
            ScreenError::Lost
        } else {
            ScreenError::Refused(message)
        })
    }
}

/// The GPU with a name, of those that can draw to the surface.
fn named(
    instance: &wgpu::Instance,
    surface: &wgpu::Surface<'_>,
    wanted: &str,
) -> Result<wgpu::Adapter, ScreenError> {
    let mut there = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    there.retain(|adapter| adapter.is_surface_supported(surface));
    let name = |adapter: &wgpu::Adapter| adapter.get_info().name;
    let found = there
        .iter()
        .position(|a| name(a).to_lowercase().contains(&wanted.to_lowercase()));
    match found {
        Some(place) => Ok(there.swap_remove(place)),
        None => Err(ScreenError::UnknownAdapter {
            wanted: wanted.to_owned(),
            available: there
                .iter()
                .map(|a| format!("{:?}", name(a)))
                .collect::<Vec<_>>()
                .join(", "),
        }),
    }
}
