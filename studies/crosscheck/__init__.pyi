from .copies import (
    copies as copies,
    cores as cores,
    end_with_parent as end_with_parent,
)
from .methods.base import (
    Discretised as Discretised,
    Method as Method,
    Solution as Solution,
    method as method,
)
from .methods.evaluation import (
    FullContact as FullContact,
)
from .methods.fem import (
    half_space_on as half_space_on,
)
from .methods.inside.interior import (
    NEAR as NEAR,
    Interior as Interior,
    first_and_last_in_contact as first_and_last_in_contact,
)
from .methods.moving_evaluation import (
    MovingContact as MovingContact,
)
from .methods.pipeline import (
    AnySpaceMethod as AnySpaceMethod,
    ComplianceMethod as ComplianceMethod,
)
from .methods.sampling.field_differences import (
    IN_STEADY_STATE as IN_STEADY_STATE,
    OVER_TIME as OVER_TIME,
    FieldComparison as FieldComparison,
    FieldDifference as FieldDifference,
    compare_fields as compare_fields,
)
from .methods.sampling.sampler import (
    AVERAGES as AVERAGES,
    Sampler as Sampler,
)
from .methods.spaces import (
    choose_spaces as choose_spaces,
    pressure_spaces as pressure_spaces,
)
from .problem.face import (
    Rings as Rings,
)
from .problem.fields import (
    Cone as Cone,
    Height as Height,
    Parabola as Parabola,
    TomlTable as TomlTable,
)
from .problem.loading import (
    Loading as Loading,
)
from .problem.norms import (
    Results as Results,
    common as common,
)
from .problem.problem import (
    Problem as Problem,
)
from .problem.profile import (
    InitialProfile as InitialProfile,
    moments as moments,
)
from .problem.quantities import (
    ANSWER as ANSWER,
    COMPARED_MODES as COMPARED_MODES,
    DESCRIBED as DESCRIBED,
    FIELDS as FIELDS,
    FINEST_RTOL as FINEST_RTOL,
    GROUPS as GROUPS,
    QUANTITIES as QUANTITIES,
    differences as differences,
    error_name as error_name,
)
from .problem.sections import (
    THINNEST_LAYER as THINNEST_LAYER,
    FemAccuracy as FemAccuracy,
    MdrAccuracy as MdrAccuracy,
)
from .problem.suggestions import (
    AnswersGuesses as AnswersGuesses,
    did_you_mean as did_you_mean,
    nearest as nearest,
)
from .problem.unit_names import (
    NO_UNIT as NO_UNIT,
    UnitNames as UnitNames,
    kind_of as kind_of,
    number_of as number_of,
    without_quantities as without_quantities,
)
from .problem.written import (
    check_one_line as check_one_line,
    one_line as one_line,
    plain as plain,
    shown as shown,
    visible as visible,
)
from .progress import (
    LOG as LOG,
    STAGES as STAGES,
    Stages as Stages,
)
from .registry import (
    METHODS as METHODS,
)
from .result.load import (
    load as load,
)
from .result.output.files import (
    CHECKSUMS as CHECKSUMS,
    INSIDE as INSIDE,
    RESULTS as RESULTS,
    RUN_FILES as RUN_FILES,
    SUMMARY as SUMMARY,
    has_checksums as has_checksums,
    read_folder as read_folder,
    write_numbers as write_numbers,
)
from .result.output.folder import (
    Folder as Folder,
    default_folder as default_folder,
    lock_folder as lock_folder,
    make as make,
    named_folder as named_folder,
    output_folder as output_folder,
    refuse_foreign_folders as refuse_foreign_folders,
)
from .result.output.vtu import (
    write_half_space as write_half_space,
)
from .result.predictions import (
    accepted_methods as accepted_methods,
    plan_run as plan_run,
    refuse_beyond_memory as refuse_beyond_memory,
    refuse_large as refuse_large,
    why_beyond_memory as why_beyond_memory,
)
from .result.result import (
    Result as Result,
)
from .result.run import (
    begun as begun,
    judged as judged,
    run as run,
    with_others as with_others,
)
from .result.scope import (
    beyond_the_model as beyond_the_model,
    chosen_methods as chosen_methods,
    left_out as left_out,
    methods_of as methods_of,
    modelled as modelled,
    refuse as refuse,
    time_scale as time_scale,
    unsuitable_methods as unsuitable_methods,
)
from .result.table import (
    in_units as in_units,
    tabulate as tabulate,
)
from .result.words import (
    Account as Account,
    Rows as Rows,
    columns as columns,
)
from .scene.calls import (
    naming_arguments as naming_arguments,
)
from .scene.explain import (
    declaration as declaration,
    keys_of as keys_of,
    place_of as place_of,
)
from .scene.keys import (
    dotted as dotted,
    listed as listed,
    numbers as numbers,
    with_key as with_key,
    without_alternatives as without_alternatives,
)
from .scene.scene import (
    Scene as Scene,
    Source as Source,
)
from .scene.sources import (
    bundled as bundled,
    profile_of_file as profile_of_file,
    tables_of as tables_of,
    text_of as text_of,
)
from .signals import (
    STOPPED as STOPPED,
    ending_on_signals as ending_on_signals,
    signals_wait as signals_wait,
)
from .sizes.finite_elements import (
    fem_sizes as fem_sizes,
    pole_orders as pole_orders,
)
from .sizes.quads import (
    GROWTH as GROWTH,
)
from .sizes.radial import (
    radial_sizes as radial_sizes,
)
from .sizes.ring_edges import (
    QUAD_GRADING as QUAD_GRADING,
)
from .sizes.shared import (
    covering as covering,
    groups as groups,
)
from .sizes.triangles import (
    triangle_degree as triangle_degree,
)
from .verdict.accuracy import (
    solved_to_accuracy as solved_to_accuracy,
    with_rtol as with_rtol,
)
from .verdict.agreement import (
    DISAGREE as DISAGREE,
    disagreement as disagreement,
)
from .verdict.promise import (
    allowed_error as allowed_error,
    unresolved as unresolved,
)
from .versions import (
    code as code,
    computed_with as computed_with,
    package_versions as package_versions,
)
from .wear.evolution import (
    evolve as evolve,
    evolve_in_equal_steps as evolve_in_equal_steps,
)
from .wear.first_contact import (
    scaled_cells as scaled_cells,
)
from .wear.flat_contact import (
    press_flat as press_flat,
)
from .wear.full_contact import (
    RunningIn as RunningIn,
)
from .wear.history import (
    History as History,
)
from .wear.unilateral import (
    Load as Load,
)
from .wear.wearing_punch import (
    WearingPunch as WearingPunch,
)
