!> Assembly: internal and external forces, and the tangent of the whole model.
module assembly
  use anchors, only: anchors_t, anchor_force
  use base_error, only: error_t
  use base_kinds, only: wp
  use base_system, only: seconds_of_both
  use constraint, only: follow, fold_force
  use contact_assembly, only: contact_work_t, new_contact_work, find_contact, contact_cliques, &
                              map_contact, add_contact, CLIQUES
  use csr, only: block_matrix_t, clique_t, new_pattern, element_map, add_element, add_batch, &
                 set_zero
  use csr_fold, only: fold_t, tied_cliques, new_fold, fold_matrix
  use dynamics_type, only: HHT
  use element_type, only: form_report_t, NB
  use external_load, only: map_t, external_force, scatter_force
  use inertia, only: mass_t, find_masses, add_inertia
  use mesh, only: is_rigid
  use model, only: model_t, state_t
  implicit none
  private
  public :: assembler_t, sweep_t, new_assembler, form, free_part, full_vector

  type :: assembler_t
    type(block_matrix_t) :: k
    logical :: new_pattern = .false.   !! the pattern of k changed and has not been analysed since
    type(contact_work_t), allocatable :: contact(:)
    type(map_t), allocatable :: map(:)
    type(fold_t) :: fold                 !! of constraints
    real(wp), allocatable :: f_int(:, :) !! (3, nnode) internal force [F]
    real(wp), allocatable :: f_contact(:, :) !! (3, nnode) contact, a part of f_int [F]
    real(wp), allocatable :: f_ext(:, :) !! (3, nnode) external force [F]
    type(mass_t), allocatable :: mass(:) !! found where the model has inertia
    real(wp), allocatable :: f_inert(:, :) !! (3, nnode) inertia, a part of f_int [F]
    type(anchors_t) :: anchors           !! of bodies that contact does not hold
    !> Wall and processor time of all sweeps, and their part of contact: search, pattern, tangent.
    real(wp) :: seconds(2) = 0.0_wp, contact_seconds(2) = 0.0_wp
  end type assembler_t

  !> The result of one sweep over the elements.
  type :: sweep_t
    logical :: ok = .true.
    integer :: block = 0, elem = 0       !! the first element that failed
    integer :: negative = 0              !! negative eigenvalues of condensed blocks
    real(wp) :: enhanced = 0.0_wp        !! energy of the enhanced residuals [F L]
    real(wp) :: rounding = 0.0_wp        !! sum of |f||u| over elements [F L]
    real(wp) :: largest = 0.0_wp         !! largest nodal force of an element [F]
  end type sweep_t

contains

  !> Allocate arrays, pattern and maps; symmetric: upper blocks only.
  subroutine new_assembler(asm, model, symmetric, error)
    type(assembler_t), intent(out) :: asm
    type(model_t), intent(in) :: model
    logical, intent(in) :: symmetric
    type(error_t), allocatable, intent(out) :: error

    call new_contact_work(model, asm%contact)
    allocate (asm%f_int(3, model%mesh%nnode), asm%f_ext(3, model%mesh%nnode))
    allocate (asm%f_inert(3, model%mesh%nnode), asm%f_contact(3, model%mesh%nnode), source=0.0_wp)
    call set_pattern(asm, model, symmetric, 0, error)
  end subroutine new_assembler

  !> Pattern of the elements and of the active contact pairs of a step.
  subroutine set_pattern(asm, model, symmetric, step, error)
    type(assembler_t), intent(inout) :: asm
    type(model_t), intent(in) :: model
    logical, intent(in) :: symmetric
    integer, intent(in) :: step
    type(error_t), allocatable, intent(out) :: error
    type(clique_t), allocatable :: clique(:)
    integer :: b, n, nblock

    nblock = size(model%mesh%block)
    allocate (clique(nblock + CLIQUES*size(asm%contact) + 1))
    do b = 1, nblock
      n = merge(0, model%mesh%block(b)%nelem, is_rigid(model%mesh%block(b)))
      clique(b)%conn = model%mesh%block(b)%conn(:, :n)
    end do
    n = size(clique) - 1
    call contact_cliques(asm%contact, model, step, clique(nblock + 1:n))
    call tied_cliques(model%mesh%constraint, model%mesh%nnode, clique(:n), clique(n + 1))
    call new_pattern(asm%k, model%mesh%nnode, clique, symmetric, error)
    if (allocated(error)) return
    if (.not. allocated(asm%map)) allocate (asm%map(nblock))
    do b = 1, nblock
      if (is_rigid(model%mesh%block(b))) cycle
      n = model%mesh%block(b)%nen
      if (.not. allocated(asm%map(b)%at)) allocate (asm%map(b)%at(n, n, model%mesh%block(b)%nelem))
      call element_map(asm%k, model%mesh%block(b)%conn, asm%map(b)%at, error)
      if (allocated(error)) return
    end do
    call map_contact(asm%contact, model, asm%k)
    call new_fold(model%mesh%constraint, asm%k, asm%fold, error)
    asm%new_pattern = .true.
  end subroutine set_pattern

  !> Compute internal and external forces, and the tangent, at the displacements of `state`. The
  !! trial history of each block is filled. The pattern changes if contact couples further elements.
  subroutine form(asm, model, state, sweep, error, only_forces)
    type(assembler_t), intent(inout) :: asm
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    type(sweep_t), intent(out) :: sweep
    type(error_t), allocatable, intent(out) :: error
    logical, intent(in), optional :: only_forces !! the tangent will not be used
    real(wp) :: start(2), start_contact(2)
    logical :: grown, symmetric
    integer :: b

    start = seconds_of_both()
    call follow(model%mesh%constraint, state%u)
    call find_contact(asm%contact, model, state, grown, only_forces)
    symmetric = asm%k%symmetric ! a copy, because set_pattern replaces asm%k
    if (grown) call set_pattern(asm, model, symmetric, state%step, error)
    if (allocated(error)) return
    asm%contact_seconds = asm%contact_seconds + seconds_of_both() - start
    asm%f_int = 0.0_wp
    call set_zero(asm%k)
    do b = 1, size(model%mesh%block)
      if (is_rigid(model%mesh%block(b))) cycle
      associate (block => model%mesh%block(b), mat => model%material(model%mesh%block(b)%material))
        if (associated(block%row%form_batch) .and. associated(mat%row%moduli) &
            .and. size(block%basis) == 1) then
          call form_batches(asm, model, state, b, sweep)
        else
          call form_elements(asm, model, state, b, sweep)
        end if
      end associate
      if (.not. sweep%ok) exit
    end do
    if (sweep%ok) then
      start_contact = seconds_of_both()
      asm%f_contact = asm%f_int
      call add_contact(asm%contact, model, state, asm%k, asm%f_int, sweep%rounding, sweep%largest, &
                       only_forces)
      asm%f_contact = asm%f_int - asm%f_contact
      asm%contact_seconds = asm%contact_seconds + seconds_of_both() - start_contact
      call form_inertia(asm, model, state)
      call external_force(model, state, asm%map, asm%k, asm%f_ext)
      ! forces and tangent of constrained slaves go to their masters
      call fold_force(model%mesh%constraint, asm%f_int)
      call fold_force(model%mesh%constraint, asm%f_ext)
      call fold_matrix(asm%fold, asm%k)
      call anchor_force(asm%anchors, state%u - state%u_step, asm%f_int)
    end if
    asm%seconds = asm%seconds + seconds_of_both() - start
  end subroutine form

  !> Add the forces of inertia and their tangent, where bodies move in time.
  !!
  !! The equations of HHT are divided by 1 + alpha, so their forces of inertia are M a/(1 + alpha)
  !! plus the share of the static force at the start of the step. These are equations of free dofs.
  !! The force of a support is M a plus the static force at the end of the step.
  subroutine form_inertia(asm, model, state)
    type(assembler_t), intent(inout) :: asm
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer :: b

    asm%f_inert = 0.0_wp
    if (.not. state%dynamics%on) return
    if (.not. allocated(asm%mass)) call find_masses(model, state%dynamics, asm%mass)
    associate (alpha => state%dynamics%alpha)
      if (state%dynamics%method == HHT) then
        where (model%eq > 0) asm%f_inert = -alpha/(1.0_wp + alpha)*state%dynamics%static
      end if
    end associate
    do b = 1, size(model%mesh%block)
      if (.not. allocated(asm%mass(b)%m)) cycle
      call add_inertia(model%mesh%block(b), asm%mass(b), state%dynamics, state, asm%map(b)%at, &
                       asm%k, asm%f_inert)
    end do
    if (state%dynamics%method == HHT) then
      ! slaves have no equations, so their forces go to the masters before supports are scaled
      call fold_force(model%mesh%constraint, asm%f_inert)
      where (model%eq == 0) asm%f_inert = (1.0_wp + state%dynamics%alpha)*asm%f_inert
    end if
    asm%f_int = asm%f_int + asm%f_inert
  end subroutine form_inertia

  !> Form one block, element by element.
  subroutine form_elements(asm, model, state, b, sweep)
    type(assembler_t), intent(inout) :: asm
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    integer, intent(in) :: b
    type(sweep_t), intent(inout) :: sweep
    real(wp), allocatable :: xr(:, :), u(:, :), du(:, :), r(:, :), k(:, :)
    type(form_report_t) :: report
    integer :: e, nen

    associate (block => model%mesh%block(b), mat => model%material(model%mesh%block(b)%material), &
               h => state%history(b))
      nen = block%nen
      allocate (xr(3, nen), u(3, nen), du(3, nen), r(3, nen), k(3*nen, 3*nen))
      do e = 1, block%nelem
        xr = model%mesh%xr(:, block%conn(:, e))
        u = state%u(:, block%conn(:, e))
        du = u - state%u_base(:, block%conn(:, e))
        call block%row%form(block%basis(block%ibasis(e)), mat%row, mat%prop, xr, u, du, &
                            state%scale, h%iter(:, e), h%trial(:, e), r, k, report)
        call note(sweep, report, b, e, r, u)
        if (.not. sweep%ok) return
        call scatter_force(block%conn(:, e), r, asm%f_int)
        call add_element(asm%k, asm%map(b)%at(:, :, e), k)
      end do
    end associate
  end subroutine form_elements

  !> Form one block, NB elements at a time; the last batch repeats its last element.
  subroutine form_batches(asm, model, state, b, sweep)
    type(assembler_t), intent(inout) :: asm
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    integer, intent(in) :: b
    type(sweep_t), intent(inout) :: sweep
    real(wp), allocatable :: xr(:, :, :), u(:, :, :), du(:, :, :), r(:, :, :), k(:, :, :, :, :)
    real(wp), allocatable :: h_old(:, :), h_new(:, :)
    type(form_report_t) :: report(NB)
    integer :: e, e0, i, lane, n, nen

    associate (block => model%mesh%block(b), mat => model%material(model%mesh%block(b)%material), &
               h => state%history(b))
      nen = block%nen
      allocate (xr(NB, 3, nen), u(NB, 3, nen), du(NB, 3, nen), r(NB, 3, nen), k(NB, 3, 3, nen, nen))
      allocate (h_old(size(h%iter, 1), NB), h_new(size(h%iter, 1), NB))
      do e0 = 0, block%nelem - 1, NB
        n = min(NB, block%nelem - e0)
        do lane = 1, NB
          e = e0 + min(lane, n)
          do i = 1, nen
            xr(lane, :, i) = model%mesh%xr(:, block%conn(i, e))
            u(lane, :, i) = state%u(:, block%conn(i, e))
            du(lane, :, i) = u(lane, :, i) - state%u_base(:, block%conn(i, e))
          end do
          h_old(:, lane) = h%iter(:, e)
        end do
        call block%row%form_batch(block%basis(1), mat%row, mat%prop, xr, u, du, state%scale, &
                                  h_old, h_new, r, k, report)
        do lane = 1, n
          e = e0 + lane
          call note(sweep, report(lane), b, e, r(lane, :, :), u(lane, :, :))
          if (.not. sweep%ok) return
          h%trial(:, e) = h_new(:, lane)
          call scatter_force(block%conn(:, e), r(lane, :, :), asm%f_int)
        end do
        call add_batch(asm%k, asm%map(b)%at(:, :, e0 + 1:e0 + n), k)
      end do
    end associate
  end subroutine form_batches

  !> Add the report of an element.
  pure subroutine note(sweep, report, b, e, r, u)
    type(sweep_t), intent(inout) :: sweep
    type(form_report_t), intent(in) :: report
    integer, intent(in) :: b, e
    real(wp), intent(in) :: r(:, :), u(:, :)

    if (.not. report%ok) then
      sweep%ok = .false.
      sweep%block = b
      sweep%elem = e
      return
    end if
    sweep%negative = sweep%negative + report%negative
    sweep%enhanced = sweep%enhanced + report%enhanced
    sweep%rounding = sweep%rounding + sum(abs(r*u))
    sweep%largest = max(sweep%largest, maxval(abs(r)))
  end subroutine note

  !> The free components of a nodal vector, in the order of the equations.
  pure subroutine free_part(eq, f, x)
    integer, intent(in) :: eq(:, :)    !! (3, nnode) equation numbers, or 0
    real(wp), intent(in) :: f(:, :)    !! (3, nnode)
    real(wp), intent(out) :: x(:)      !! (neq)
    integer :: i, n

    do n = 1, size(eq, 2)
      do i = 1, 3
        if (eq(i, n) > 0) x(eq(i, n)) = f(i, n)
      end do
    end do
  end subroutine free_part

  !> A nodal vector from its free components; zero elsewhere.
  pure subroutine full_vector(eq, x, f)
    integer, intent(in) :: eq(:, :)    !! (3, nnode)
    real(wp), intent(in) :: x(:)       !! (neq)
    real(wp), intent(out) :: f(:, :)   !! (3, nnode)
    integer :: i, n

    f = 0.0_wp
    do n = 1, size(eq, 2)
      do i = 1, 3
        if (eq(i, n) > 0) f(i, n) = x(eq(i, n))
      end do
    end do
  end subroutine full_vector

end module assembly
