//! Messages: the facts of a start, a rejection, a blow-up.

use crate::dem::block::Partner;
use crate::dem::diagnosis::suggestions;
use crate::dem::diagnosis::{Diagnosis, figure};
use crate::dem::discs::Discs;
use crate::dem::materials::Dashpot;
use crate::dem::parameters::Parameters;
use crate::dem::totals::BlowUp;
use crate::dem::{restitution, start};
use crate::model::{SetupError, SimulationFault};
use crate::short_number::short;
use kinetoscope_console::Message;
use kinetoscope_manifest::model::{DemConfig, DemDashpot, Placement, UnstableTimeStep};

/// The property and the cost of an implicit dashpot.
const OF_IMPLICIT_DASHPOT: &str =
    "stable for any damping; far above critical damping it dissipates more than an exact dashpot";

/// Whether an implicit dashpot is another choice.
fn is_choice(config: &DemConfig) -> bool {
    config.dashpot == DemDashpot::Explicit && config.may_be_implicit()
}

/// The error of a start that is rejected.
pub(crate) fn rejection(config: &DemConfig, diagnosis: &Diagnosis) -> SetupError {
    let mut help = nearest_accepted(config, ["no", "the"]);
    if is_choice(config) && diagnosis.is_unstable() {
        help += &format!(". dashpot = \"implicit\" is {OF_IMPLICIT_DASHPOT}");
    }
    if config.on_unstable_time_step == UnstableTimeStep::Error {
        help += ". With on_unstable_time_step = \"warn\", the run starts anyway";
    }
    SetupError::new(diagnosis.problems("the").join("; "), help)
}

/// The recorded warning of a start that would be rejected, but is wanted.
pub(crate) fn warning(config: &DemConfig, diagnosis: &Diagnosis) -> String {
    let mut sentences = diagnosis.problems("The");
    sentences.push(nearest_accepted(config, ["No", "The"]));
    if is_choice(config) && diagnosis.is_unstable() {
        sentences.push(format!("dashpot = \"implicit\" is {OF_IMPLICIT_DASHPOT}"));
    }
    sentences.join(". ") + "."
}

/// What to change, beginning with one of the words given.
fn nearest_accepted(config: &DemConfig, [no, the]: [&str; 2]) -> String {
    let suggestions = suggestions::find(config);
    let own = config.materials.iter().map(|material| &material.constants);
    let own = own.chain(config.contact_pairs.iter().map(|pair| &pair.constants));
    let has_own = own.into_iter().any(|it| it.stiffness_ratio.is_some() || it.cohesion_n.is_some());
    // They are not searched.
    let others = if has_own {
        ". The stiffness_ratio and cohesion_n of materials and contact_pairs count as well"
    } else {
        ""
    };
    if suggestions.is_empty() {
        let keys = "the time step, the dashpot, the stiffness and the radius";
        format!("{no} single change of {keys} is sufficient: change two of them{others}")
    } else {
        format!("{the} nearest accepted values, each alone: {}{others}", suggestions.join("; "))
    }
}

/// The figures of the start, one line each.
pub(crate) fn facts(
    config: &DemConfig,
    parameters: &Parameters,
    diagnosis: &Diagnosis,
    discs: &Discs,
) -> Vec<String> {
    let placed = match config.placement {
        Placement::Random => "at random",
        Placement::Lattice => "on a square lattice",
        Placement::Given(_) => "as given",
        Placement::Recorded(_) => {
            "where the recording ended, springs of friction unstretched and discs renumbered"
        }
    };
    vec![
        format!(
            "{} discs placed {placed}, packing fraction {:.4}.",
            discs.radii.len(),
            start::packing_fraction(&discs.radii, parameters.sides)
        ),
        format!(
            "Time step {:e} s, {} steps. {}",
            parameters.time_step,
            parameters.total_steps,
            contact_steps(config, parameters)
        ),
        dashpot(config, parameters, diagnosis),
    ]
}

/// The true number of steps per contact: the DEM exercise's formula has the mass m where two discs have m/2.
fn contact_steps(config: &DemConfig, parameters: &Parameters) -> String {
    let steps = |effective_mass: f64| {
        let ratio = parameters.strongest_damping_ratio(effective_mass);
        let (law, mass) = (&parameters.law, parameters.law.mass_of_stiffest(effective_mass));
        let duration = law.normal.contact_duration(mass, ratio, config.limit_damping);
        duration.map(|duration| duration / parameters.time_step)
    };
    let (softest, stiffest) = parameters.law.materials.stiffness_range();
    let of_stiffest = if softest < stiffest { ", of the stiffest pair of materials," } else { "" };
    let at = match parameters.law.normal.largest() {
        [overlap, _] if overlap > 0.0 => {
            format!("At the largest expected overlap, {overlap:.3e} m, a contact")
        }
        _ => "A contact".to_owned(),
    };
    match (steps(parameters.lightest_pair_mass()), steps(parameters.smallest_mass)) {
        (Some(pair), Some(wall)) => format!(
            "{at} of the lightest discs{of_stiffest} lasts {pair:.1} steps with each other, {wall:.1} with a wall."
        ),
        _ => "The dashpot is overdamped: contacts do not end.".to_owned(),
    }
}

fn dashpot(config: &DemConfig, parameters: &Parameters, diagnosis: &Diagnosis) -> String {
    let mass = parameters.lightest_pair_mass();
    let ratio = parameters.strongest_damping_ratio(mass);
    let tail = match config.limit_damping {
        false => "with the attractive tail",
        true => "clamped at zero",
    };
    let given = match parameters.law.materials.strongest_dashpot().dashpot {
        Dashpot::Ratio(_) => "from the restitution wanted",
        Dashpot::Damping(_) => "as given",
    };
    let implicit = match config.dashpot {
        DemDashpot::Implicit => format!(" The dashpot is implicit: {OF_IMPLICIT_DASHPOT}."),
        DemDashpot::Explicit => String::new(),
    };
    format!(
        "Lightest pair: eta = {:.6e} N s/m {given}, zeta = {ratio:.6}, restitution {:.6} {tail}, \
         c = eta dt/m_eff = {}.{implicit}",
        parameters.strongest_damping(),
        restitution::restitution(ratio, config.limit_damping),
        figure(diagnosis.damping_step)
    )
}

/// The message of a blow-up after a number of steps, at a time in s: its place and what to change.
pub(crate) fn fault(
    parameters: &Parameters,
    discs: &Discs,
    (count, time): (u64, f64),
    damping_step: f64,
    blow_up: BlowUp,
) -> SimulationFault {
    let what = |number: fn(f64) -> String| match blow_up {
        BlowUp::Overlap(disc, partner, over_radius) => {
            let partner = match partner {
                Partner::Disc(partner) => format!("disc {}", discs.ids[partner as usize]),
                Partner::Wall(wall) => format!("wall {wall}"),
            };
            format!(
                "disc {} and {partner} overlap by {} radii",
                discs.ids[disc as usize],
                figure(over_radius)
            )
        }
        BlowUp::Outside(disc) => {
            let ([x, y], [vx, vy]) = (discs.positions[disc], discs.velocities[disc]);
            let id = discs.ids[disc];
            format!(
                "the center of disc {id} left the box, at ({}, {}) m with a velocity of ({}, {}) m/s",
                number(x),
                number(y),
                number(vx),
                number(vy)
            )
        }
        BlowUp::Residual(fraction) => format!(
            "the energy balance does not close: its residual is {} of all energy",
            figure(fraction)
        ),
    };
    let stiffness = parameters.law.normal.key();
    let less = if parameters.law.is_cohesive() { ", less cohesion_n" } else { "" };
    let implicit = if parameters.law.is_cohesive() { "" } else { ", or dashpot = \"implicit\"" };
    let advice = if damping_step >= 0.3 && !parameters.law.is_implicit {
        format!(
            "dashpot is too strong for the time step: take more steps_per_wall_contact (or a shorter time_step_s), less \
             damping_n_s_per_m (or a higher restitution){implicit}"
        )
    } else {
        format!(
            "contacts are too soft for the speed or the load: take a higher {stiffness}{less} or a larger radius_m; or \
             the time step is too long: take more steps_per_wall_contact"
        )
    };
    let text = |number: fn(f64) -> String| {
        let (what, time, damping_step) = (what(number), number(time), figure(damping_step));
        format!("Blow-up at step {count} (t = {time} s): {what}. c = eta dt/m_eff = {damping_step}")
    };
    let recorded = format!("{}. The {advice}.", text(|number| format!("{number:e}")));
    SimulationFault::recorded_as(Message::new(text(short), format!("the {advice}")), recorded)
}
