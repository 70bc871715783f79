//! Published skies behind one interface, so that speed and accuracy can be compared.
pub mod aerial;
pub mod atmosphere;
mod cache;
pub mod cie;
pub mod hoffman;
pub mod hosek;
pub mod nielsen;
pub mod phase;
pub mod preetham;
#[cfg(test)]
mod shader_check;
pub mod texture;
mod view;
