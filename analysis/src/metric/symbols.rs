//! The symbols of all formulas: one meaning per symbol, and one symbol per quantity.

use std::collections::BTreeSet;

/// Each symbol with its meaning.
pub(crate) const SYMBOLS: &[(&str, &str)] = &[
    ("A", "area of the container, or of a layer of a bed"),
    ("A_s", "area in which species s starts"),
    ("B", "number of boxes on each side of a partition"),
    ("C", "number of pair collisions since the start"),
    ("D", "self-diffusion coefficient"),
    ("E", "energy; per unit mass for one body around the Sun"),
    ("E_0", "initial energy"),
    ("F", "force"),
    ("F_g", "weight of a bed"),
    ("F_s", "saturation weight of a silo"),
    ("F_y", "vertical component of a contact force"),
    ("GM", "gravitational constant times the Sun's mass"),
    ("H", "Boltzmann's H function"),
    ("I", "moment of inertia of a uniform disc, half its mass times its radius squared"),
    ("L", "angular momentum, r × v for one body"),
    ("L_0", "initial angular momentum"),
    ("N", "number of particles"),
    ("P", "pressure"),
    ("Q", "wave vector of a density wave; its length where it is not in a product"),
    ("R", "radius of a circular container"),
    ("S", "structure factor; without an argument, in the limit of long waves"),
    ("S_xx", "horizontal normal stress, compression positive"),
    ("S_yy", "vertical normal stress, compression positive"),
    (
        "T",
        "temperature; in K for gas, half the mean square of the velocity relative to its mean for DEM and packing",
    ),
    ("T_0", "initial temperature"),
    ("W", "virial of the pair collisions: sum of distance times normal impulse"),
    ("Z", "compressibility factor, P A over that of the ideal gas"),
    ("a2", "second Sonine coefficient, <v^4>/(2 <v^2>^2) - 1"),
    ("a_0", "initial semi-major axis"),
    ("d", "diameter of a disc"),
    ("d_i", "diameter of disc i"),
    ("d_ij", "mean of the diameters of discs i and j"),
    ("d_j", "diameter of disc j"),
    ("e", "coefficient of restitution"),
    ("g", "acceleration of gravity"),
    ("g(r)", "pair correlation function at the distance r of two discs"),
    ("i", "imaginary unit"),
    ("k_B", "Boltzmann's constant"),
    ("k_n", "normal stiffness of a contact"),
    ("l", "branch of a contact: the vector between the centers, or from the wall to the center"),
    ("l_y", "vertical component of a branch"),
    ("m", "mass of a particle"),
    ("m_eff", "effective mass of a contact, m1 m2/(m1 + m2); m at a wall"),
    ("n", "number of particles per area"),
    ("p", "the measured fraction of particles"),
    ("q", "<d>^2/<d^2>"),
    ("r", "position; |r| is the distance from the Sun"),
    ("t", "time since the start"),
    ("u_0", "eccentric anomaly at the start"),
    ("u_y", "vertical velocity relative to the mean of a layer"),
    ("v", "velocity, or speed"),
    ("v_rms", "root mean square speed"),
    ("w", "width of an orifice"),
    ("x_s", "fraction of the particles that belong to species s"),
    ("y", "height above the center of the container"),
    ("Δt", "time step"),
    ("Ω", "angular velocity of a disc"),
    ("δ_max", "largest overlap of a contact"),
    ("ε", "eccentricity"),
    ("ζ", "damping ratio, η_n/(2 sqrt(k_n m_eff))"),
    ("η_n", "normal damping of a contact"),
    ("θ", "direction of the line from a disc to its neighbor"),
    (
        "κ",
        "force of a contact over the overlap to the power 3/2, by Hertz's law: (4/3) E* sqrt(r) with the effective modulus E*",
    ),
    ("ν", "pair collision rate per disc"),
    ("σ", "standard error; deviations from theory are given in σ"),
    ("τ", "time scale of Haff's law"),
    ("φ", "packing fraction"),
    ("χ", "pair correlation function at contact"),
    ("χ_ij", "pair correlation function at contact of discs i and j"),
    ("ω", "angular frequency of a contact, or mean motion of an orbit at the start"),
];

/// The symbols in these texts, in the order of the table, with their meanings.
pub(crate) fn used<'a>(
    texts: impl IntoIterator<Item = &'a str>,
) -> impl Iterator<Item = &'static (&'static str, &'static str)> {
    let found: BTreeSet<&str> = texts.into_iter().flat_map(symbols_in).collect();
    let found: Vec<_> = SYMBOLS.iter().filter(|(symbol, _)| found.contains(symbol)).collect();
    found.into_iter()
}

/// The symbols of a text: letters, also with a subscript, and pairs of letters or digits that are not two small Latin
/// letters. The article "a" and the "s" of a genitive are no symbols.
fn symbols_in(text: &str) -> Vec<&str> {
    let mut found: Vec<&str> = text.matches("g(r)").map(|_| "g(r)").collect();
    for word in text.split("g(r)").flat_map(|part| part.split("'s")) {
        let tokens = word.split(|letter: char| !letter.is_alphanumeric() && letter != '_');
        let tokens =
            tokens.map(|token| token.trim_start_matches(|digit: char| digit.is_ascii_digit()));
        found.extend(tokens.filter(|token| {
            let letters = token.chars().count();
            let has_subscript = token.chars().nth(1) == Some('_');
            let is_word = token.chars().all(|letter| letter.is_ascii_lowercase());
            has_subscript || letters == 1 && *token != "a" || letters == 2 && !is_word
        }));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::MODELS;

    fn formulas() -> Vec<&'static str> {
        let definitions =
            MODELS.iter().flat_map(|model| model.metrics.iter().chain(model.sweep_metrics));
        definitions
            .flat_map(|definition| {
                definition.laws.iter().map(|law| law.statement).chain([definition.how])
            })
            .collect()
    }

    #[test]
    fn every_symbol_of_a_formula_is_in_the_table() {
        let known: BTreeSet<&str> = SYMBOLS.iter().map(|(symbol, _)| *symbol).collect();
        for formula in formulas() {
            for symbol in symbols_in(formula) {
                assert!(known.contains(symbol), "{symbol} in: {formula}");
            }
        }
        // Control: symbols of other conventions are found and are not in the table.
        for other in ["E0", "kT", "Ws", "f", "s", "α", "sigma_yy"] {
            let text = format!("2{other}/3");
            let found = symbols_in(&text);
            assert!(found.iter().all(|symbol| !known.contains(symbol)), "{other}");
            assert_eq!(found.len(), usize::from(other != "sigma_yy"), "{other}");
        }
    }

    #[test]
    fn symbols_and_meanings_are_unique_and_used() {
        let meanings: BTreeSet<&str> = SYMBOLS.iter().map(|(_, meaning)| *meaning).collect();
        assert_eq!(meanings.len(), SYMBOLS.len());
        assert!(SYMBOLS.is_sorted_by(|(one, _), (other, _)| one < other));
        let used: Vec<&str> = used(formulas()).map(|(symbol, _)| *symbol).collect();
        let unused =
            SYMBOLS.iter().map(|(symbol, _)| *symbol).filter(|symbol| !used.contains(symbol));
        // Deviations are printed in σ.
        assert_eq!(unused.collect::<Vec<_>>(), ["σ"]);
    }

    /// A symbol is defined in the table only, not next to a formula.
    #[test]
    fn formulas_define_no_symbol() {
        for formula in formulas() {
            for (symbol, _) in SYMBOLS {
                assert!(!formula.contains(&format!(", {symbol} the ")), "{formula}");
                assert!(!formula.contains(&format!(", {symbol} is ")), "{formula}");
            }
        }
    }
}
