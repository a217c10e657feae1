"""Tags of SDF 1.0 to 1.12, by their parent element; see `table`."""

from __future__ import annotations

from teleopctl.robot.tags.table import Table

_STIFF = "contacts are as stiff as steps of physics allow, and DART does not read it"
# Contact properties of a shape; ``{0}`` is replaced by the path of the parent element.
SURFACE = f"""
    + {{0}}surface/friction/ode: mu mu2
    + {{0}}surface/friction/torsional: coefficient patch_radius
    - {{0}}surface/friction/torsional: use_patch_radius=true=1 surface_radius ode/slip
    - {{0}}surface/friction/ode: slip1 slip2
    > {{0}}surface/friction/ode: fdir1
    + {{0}}surface/friction/bullet: rolling_friction
    * {{0}}surface/friction/bullet: friction friction2 fdir1
    + {{0}}surface/bounce: restitution_coefficient
    * {{0}}surface/bounce: threshold
    - {{0}}surface/contact: collide_without_contact=false=0 collide_without_contact_bitmask=1
    - {{0}}surface/contact: collide_bitmask=65535=0xffff category_bitmask=65535=0xffff
    * {{0}}surface/contact: poissons_ratio elastic_modulus bullet
    - {{0}}surface/contact/ode: kp=1e12 kd=1 | {_STIFF}
    * {{0}}surface/contact/ode: soft_cfm soft_erp=0.2 max_vel=0.01 min_depth
    - {{0}}surface: soft_contact
"""

ROOT = Table("""
    + .: @version
    > .: world model light
    - .: actor
""")
# The reader of <spherical_coordinates> reports values of its children that are not supported.
WORLD = Table("""
    + .: @name gravity magnetic_field frame*@name@attached_to frame/pose
    + physics: @name @default gravity
    - physics: @type=ode | MuJoCo simulates
    * physics: max_step_size=0.001 real_time_factor real_time_update_rate max_contacts ode bullet
    * physics: simbody dart update_rate
    > .: model include light plugin joint
    + spherical_coordinates: surface_model world_frame_orientation latitude_deg longitude_deg
    + spherical_coordinates: elevation heading_deg
    - spherical_coordinates: surface_axis_equatorial surface_axis_polar
    + .: state*@world_name
    + state: model*@name model/pose
    + state/model: frame*@name frame/pose link*@name link/pose
    - state/model: model joint scale=1_1_1
    * state/model/link: velocity acceleration wrench collision
    * state: sim_time wall_time real_time iterations light
    - state: insertions deletions joint
    * .: gui scene gz:policies
    - .: wind atmosphere actor road population audio
""")
INCLUDE = Table("""
    + .: @merge uri name static pose placement_frame
    > .: plugin
    - .: namespace experimental:params
""")
MODEL = Table("""
    + .: @name @canonical_link @placement_frame static pose self_collide
    + .: frame*@name@attached_to frame/pose
    > .: link joint model include plugin
    * .: @version @xmlns allow_auto_disable=true=1
    - .: enable_wind=false=0 gripper @namespace model_state
""")
LINK = Table("""
    + .: @name pose gravity self_collide
    + inertial: @auto pose mass inertia
    + inertial/inertia: ixx ixy ixz iyy iyz izz
    - inertial: fluid_added_mass | there is no fluid
    - inertial: density=1000 auto_inertia_params
    > .: visual collision sensor
    - .: kinematic=false=0 damping enable_wind=false=0 must_be_base_link=false=0
    - velocity_decay: linear angular
    - .: projector audio_sink audio_source battery light particle_emitter
""")
GEOMETRY = Table("""
    + .: box/size sphere/radius ellipsoid/radii plane/size plane/normal
    + cylinder: radius length
    + capsule: radius length
    + cone: radius length
    + mesh: uri scale
    - mesh: @optimization convex_decomposition
    + heightmap: uri size pos
    * heightmap: texture blend use_terrain_paging sampling
    > mesh: submesh
    > .: polyline image empty
""")
VISUAL = Table("""
    + .: @name pose transparency
    > .: geometry
    + material: diffuse ambient script/name pbr/metal/albedo_map pbr/specular/albedo_map
    * material: specular emissive shininess shader render_order lighting=true=1 double_sided
    * material: script/uri
    * material/pbr/metal: roughness_map roughness metalness_map metalness environment_map normal_map
    * material/pbr/metal: ambient_occlusion_map emissive_map light_map
    * material/pbr/specular: specular_map glossiness_map glossiness environment_map normal_map
    * material/pbr/specular: ambient_occlusion_map emissive_map light_map
    * .: cast_shadows=true=1 meta visibility_flags=4294967295 laser_retro
    - .: plugin
""")
COLLISION = Table(
    """
    + .: @name pose density
    > .: geometry
    * .: max_contacts
    - .: laser_retro auto_inertia_params
    """
    + SURFACE.format("")
)
LIGHT = Table("""
    + .: @name @type pose diffuse specular direction cast_shadows light_on
    + attenuation: constant linear quadratic
    + .: spot/outer_angle
    * .: visualize attenuation/range spot/inner_angle spot/falloff
    - .: intensity=1
""")
_AXIS = """
    + {0}: xyz@expressed_in use_parent_model_frame mimic@joint@axis
    + {0}/limit: lower upper effort velocity
    * {0}/limit: stiffness=1e8 dissipation=1
    + {0}/dynamics: damping friction spring_stiffness spring_reference
    - {0}: initial_position
    + {0}/mimic: multiplier offset reference
"""
_JOINT = """
    + .: @name @type pose parent child
    > .: sensor
    * physics: simbody ode provide_feedback
"""
_NO_GEARBOX = "- .: gearbox_ratio=0=1 gearbox_reference_body\n"
_NO_SCREW = "- .: thread_pitch=0=1 screw_thread_pitch=0=1\n"

JOINT = Table(_JOINT + _AXIS.format("axis") + _NO_GEARBOX + _NO_SCREW + "- .: axis2")
JOINT_OF_TWO = Table(
    _JOINT + _AXIS.format("axis") + _AXIS.format("axis2") + _NO_GEARBOX + _NO_SCREW
)
SCREW = Table(
    _JOINT + _AXIS.format("axis") + _NO_GEARBOX + "+ .: thread_pitch screw_thread_pitch\n- .: axis2"
)
GEARBOX = Table(
    _JOINT
    + """
    + .: gearbox_ratio gearbox_reference_body
    + axis: xyz@expressed_in use_parent_model_frame
    + axis2: xyz@expressed_in use_parent_model_frame
    * axis: limit dynamics mimic initial_position
    * axis2: limit dynamics mimic initial_position
    """
    + _NO_SCREW
)
