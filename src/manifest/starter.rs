//! Starter manifests: every key of a model with its unit and default, commented.

/// A commented manifest of a model to begin from: all its keys, at their defaults.
#[must_use]
pub fn starter(model: &str) -> Option<&'static str> {
    match model {
        "dem" => Some(include_str!("starter/dem.toml")),
        "gas" => Some(include_str!("starter/gas.toml")),
        "packing" => Some(include_str!("starter/packing.toml")),
        "orbit" => Some(include_str!("starter/orbit.toml")),
        _ => None,
    }
}
