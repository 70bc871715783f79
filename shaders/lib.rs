//! The shaders of the UTM sky model as WGSL text. WGSL has no includes: `sky-gpu` puts the parts of a
//! program one after the other.

/// `aerial.wgsl`.
pub const AERIAL: &str = include_str!("aerial.wgsl");
/// `baked.wgsl`.
pub const BAKED: &str = include_str!("baked.wgsl");
/// `color.wgsl`.
pub const COLOR: &str = include_str!("color.wgsl");
/// `composite.wgsl`.
pub const COMPOSITE: &str = include_str!("composite.wgsl");
/// `composite_multisampled.wgsl`.
pub const COMPOSITE_MULTISAMPLED: &str = include_str!("composite_multisampled.wgsl");
/// `dither.wgsl`.
pub const DITHER: &str = include_str!("dither.wgsl");
/// `dome.wgsl`.
pub const DOME: &str = include_str!("dome.wgsl");
/// `hdr.wgsl`.
pub const HDR: &str = include_str!("hdr.wgsl");
/// `hdr10.wgsl`.
pub const HDR10: &str = include_str!("hdr10.wgsl");
/// `linear.wgsl`.
pub const LINEAR: &str = include_str!("linear.wgsl");
/// `perez.wgsl`.
pub const PEREZ: &str = include_str!("perez.wgsl");
/// `picture.wgsl`.
pub const PICTURE: &str = include_str!("picture.wgsl");
/// `scene.wgsl`.
pub const SCENE: &str = include_str!("scene.wgsl");
/// `scrgb.wgsl`.
pub const SCRGB: &str = include_str!("scrgb.wgsl");
/// `sky_frame.wgsl`.
pub const SKY_FRAME: &str = include_str!("sky_frame.wgsl");
/// `tonemap.wgsl`.
pub const TONEMAP: &str = include_str!("tonemap.wgsl");
/// `uniforms.wgsl`.
pub const UNIFORMS: &str = include_str!("uniforms.wgsl");
/// `utm_sky.wgsl`.
pub const UTM_SKY: &str = include_str!("utm_sky.wgsl");
/// `view.wgsl`.
pub const VIEW: &str = include_str!("view.wgsl");

/// Skies of other models, for `sky-baselines`.
pub mod baselines {
    /// `baselines/cie_clear.wgsl`.
    pub const CIE_CLEAR: &str = include_str!("baselines/cie_clear.wgsl");
    /// `baselines/cie_overcast.wgsl`.
    pub const CIE_OVERCAST: &str = include_str!("baselines/cie_overcast.wgsl");
    /// `baselines/dobashi.wgsl`.
    pub const DOBASHI: &str = include_str!("baselines/dobashi.wgsl");
    /// `baselines/hillaire.wgsl`.
    pub const HILLAIRE: &str = include_str!("baselines/hillaire.wgsl");
    /// `baselines/hoffman.wgsl`.
    pub const HOFFMAN: &str = include_str!("baselines/hoffman.wgsl");
    /// `baselines/hosek.wgsl`.
    pub const HOSEK: &str = include_str!("baselines/hosek.wgsl");
    /// `baselines/nielsen.wgsl`.
    pub const NIELSEN: &str = include_str!("baselines/nielsen.wgsl");
    /// `baselines/nishita.wgsl`.
    pub const NISHITA: &str = include_str!("baselines/nishita.wgsl");
    /// `baselines/nishita_table.wgsl`.
    pub const NISHITA_TABLE: &str = include_str!("baselines/nishita_table.wgsl");
    /// `utm_sky.wgsl`, `perez.wgsl` and `baselines/perez_table.wgsl`.
    pub const PEREZ_TABLE: &str = concat!(
        include_str!("utm_sky.wgsl"),
        include_str!("perez.wgsl"),
        include_str!("baselines/perez_table.wgsl"),
    );
    /// `baselines/preetham.wgsl`.
    pub const PREETHAM: &str = include_str!("baselines/preetham.wgsl");
}
