//! `[model.gas]`: sizes at which products do not overflow and positions keep their digits.

use super::gas::GasConfig;
use super::gas_start::SpeedScale;
use super::sizes::{LARGEST, SMALLEST, length, nearest_size};
use crate::keys::{Reader, rules};

/// Maximum distance of the center from the origin in radii: beyond it, absolute positions have fewer than seven digits.
const MAX_CENTER_DISTANCE_IN_RADII: f64 = 1e9;

/// Bounds of the thermal speed sqrt(2 k_B T/m), m/s: that of the fastest particle is up to nine times as large.
const THERMAL_SPEEDS: [f64; 2] = [10.0 * SMALLEST, 0.1 * LARGEST];

impl GasConfig {
    /// Reports all sizes outside their ranges.
    pub(super) fn check_sizes(&self, table: &mut Reader<'_>) {
        let (mass, radius) = (self.mass_kg.get(), self.radius_m.get());
        let mut sizes = vec![
            ("mass_kg", mass),
            ("radius_m", radius),
            ("duration_s", self.duration_s.get()),
            ("gravity_m_per_s2", self.gravity_m_per_s2.get()),
        ];
        sizes.extend(self.speeds_m_per_s.iter().map(|speed| ("speeds_m_per_s", speed.get())));
        if let SpeedScale::MaxSpeed(speed) = self.speed_scale {
            sizes.push(("max_speed_m_per_s", speed.get()));
        }
        for (key, size) in sizes {
            let nearest = nearest_size(size);
            rules! { table;
                size != 0.0 && size != nearest => [key]
                    "`{key}` is {size:e}, at which products overflow", "must be in [{SMALLEST:e}, {LARGEST:e}]; the nearest value is {nearest:e}";
            }
        }
        if let SpeedScale::Temperature(temperature) = self.speed_scale {
            let thermal = (2.0 * 1.380_649e-23 * temperature.get() / mass).sqrt();
            let [least, most] = THERMAL_SPEEDS;
            let bound = if thermal < least { least } else { most };
            let nearest = mass * bound * bound / (2.0 * 1.380_649e-23);
            rules! { table;
                thermal > 0.0 && !(least..=most).contains(&thermal) => ["temperature_k", "mass_kg"]
                    "particles with a speed of {thermal:e} m/s, at which products overflow", "the nearest `temperature_k` that works is {nearest:e}";
            }
        }
        let distance = length(self.center_m);
        let limit = MAX_CENTER_DISTANCE_IN_RADII * radius;
        let [x, y] = self.center_m.map(|axis| axis.get() * (limit / distance));
        rules! { table;
            distance > limit => ["center_m", "radius_m"]
                "`center_m` is {distance:e} m from the origin, so far that positions lose their digits",
                "must be within {MAX_CENTER_DISTANCE_IN_RADII:e} radii; the nearest value is [{x:e}, {y:e}]";
        }
    }
}
