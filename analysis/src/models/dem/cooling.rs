//! Cooling of a free granular gas by Haff's law.

use crate::models::series::Series;
use kinetoscope_manifest::model::{DemConfig, PeriodicSides};

/// Granular temperature over time of discs without a heat source.
#[derive(Clone, Debug, Default)]
pub(super) struct Cooling {
    temperature: Series<(f64, f64)>,
}

impl Cooling {
    pub(super) fn add_frame(&mut self, time: f64, temperature: f64) {
        self.temperature.add((time, temperature));
    }

    /// The temperature at the start, m^2/s^2.
    pub(super) fn first(&self) -> Option<f64> {
        self.temperature.first().map(|&(_, temperature)| temperature)
    }

    /// 1/tau of T = T0 / (1 + t/tau)^2, 1/s: the slope of sqrt(T0/T) - 1 over t, by least squares through the origin.
    pub(super) fn rate_per_s(&self) -> Option<f64> {
        let &(begin, first) = self.temperature.first()?;
        let (mut products, mut squares) = (0.0, 0.0);
        for &(time, temperature) in self.temperature.iter() {
            let since = time - begin;
            products += since * ((first / temperature).sqrt() - 1.0);
            squares += since * since;
        }
        (squares > 0.0 && first > 0.0).then(|| products / squares)
    }
}

/// Whether discs cool freely: no walls and no gravity.
pub(crate) fn is_free_gas(config: &DemConfig) -> bool {
    let falls = config.gravity_m_per_s2.iter().any(|component| component.get() != 0.0);
    config.periodic == PeriodicSides::Both && !falls && config.walls.is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_of_haffs_law_is_found() {
        let mut cooling = Cooling::default();
        for frame in 0..50 {
            let time = 0.02 * f64::from(frame);
            cooling.add_frame(time, 4e-3 / ((1.0 + 3.0 * time) * (1.0 + 3.0 * time)));
        }
        assert!((cooling.rate_per_s().unwrap() - 3.0).abs() < 1e-12);
    }
}
