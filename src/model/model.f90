!> The two main types: the model, which does not change once it is built, and its current state.
module model
  use base_error, only: place_t
  use base_kinds, only: wp, i8
  use boundary, only: boundary_t
  use contact_pair, only: contact_t, contact_state_t
  use curve_type, only: curve_t
  use dynamics_type, only: dynamics_t
  use energy_type, only: energy_t
  use load_curve, only: load_table_t
  use material_type, only: material_t, MAX_PROP
  use mesh, only: mesh_t
  implicit none
  private
  public :: model_t, state_t, material_set_t, unread_t

  !> One MATErial of the deck.
  type :: material_set_t
    integer :: number = 0                !! the user's number
    type(material_t) :: row
    real(wp) :: prop(MAX_PROP) = 0.0_wp
    real(wp) :: density = 0.0_wp         !! [M/L^3]
    real(wp) :: body_force(3) = 0.0_wp   !! [F/L^3] at factor 1
    integer :: body_table = 0
    logical :: enhanced = .false.        !! ENHAnced (ELEM and BLOC meshes)
    logical :: given_formulation = .false. !! DISPlacement or ENHAnced is given (error in a PATCh)
    integer :: nurbs_points(3) = 0       !! q1 q2 q3 of the record NURB interp
    type(place_t) :: place
  end type material_set_t

  !> A file that exists next to a file of the deck but is not read; `text` is the warning about it.
  type :: unread_t
    integer(i8) :: identity(2) = 0
    character(:), allocatable :: text
    type(place_t) :: place
  end type unread_t

  !> The model to be analysed; it does not change after the set-up.
  type :: model_t
    character(:), allocatable :: title
    type(mesh_t) :: mesh
    type(material_set_t), allocatable :: material(:)
    type(boundary_t) :: bc
    type(contact_t), allocatable :: contact(:)
    type(curve_t), allocatable :: curve(:)
    type(unread_t), allocatable :: unread(:)
    !> Equation numbers of the free dofs; 0: the dof is prescribed.
    integer, allocatable :: eq(:, :)     !! (3, nnode)
    integer :: neq = 0
    integer :: ndof = 0                  !! dofs of nodes in use, without those of rigid bodies
  end type model_t

  !> History of one block; see element_form_i.
  type, public :: history_t
    real(wp), allocatable :: step(:, :)  !! (nparam, nelem) parameters at the start of the step
    real(wp), allocatable :: iter(:, :)  !! (nhist, nelem) history after the last iteration
    real(wp), allocatable :: trial(:, :) !! (nhist, nelem) history of the trial state
  end type history_t

  !> State of the analysis.
  type :: state_t
    integer :: step = 0
    real(wp) :: time = 0.0_wp, dt = 0.0_wp
    real(wp), allocatable :: u(:, :)      !! (3, nnode) displacements [L]
    real(wp), allocatable :: u_step(:, :) !! displacements at the start of the step [L]
    real(wp), allocatable :: last_increment(:, :) !! (3, nnode) u - u_step of the last accepted step
    real(wp) :: last_dt = 0.0_wp          !! time increment of the last accepted step [T]
    real(wp), allocatable :: u_base(:, :) !! displacements from which the last increment started [L]
    real(wp) :: scale = 0.0_wp            !! fraction of the Newton increment in u - u_base
    real(wp), allocatable :: reaction(:, :) !! (3, nnode) internal minus external force [F]; at free
    !! dofs the residual
    real(wp), allocatable :: reaction_step(:, :) !! the same at the start of the step [F]
    real(wp), allocatable :: factor(:)    !! factor of each load table
    real(wp), allocatable :: factor_step(:) !! the same at the end of the previous step; not
    !! allocated: there is none
    type(load_table_t), allocatable :: table(:)
    type(history_t), allocatable :: history(:) !! one for each block
    type(contact_state_t), allocatable :: contact(:) !! one for each contact
    type(dynamics_t) :: dynamics
    type(energy_t) :: energy
  end type state_t

end module model
