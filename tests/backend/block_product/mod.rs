//! Locally adaptive products against naive twins and ground truth; their files.

mod bounded;
mod closures;
mod exact;
mod extremes;
mod file;
mod fixed;
mod frames;
mod layout;
mod light;
mod support;
mod transport;
