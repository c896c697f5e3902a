!> Assembly of the internal and external forces and of the tangent of the whole model.
!!
!! Each rank forms some of the elements of each block. The forces of these elements are sent to all
!! ranks, which add them in the order of the elements, so that the residual is the same, bit for
!! bit, on any number of ranks. The matrices stay on the rank: the tangent is the sum of the
!! matrices on all ranks.
module assembly
  use anchors, only: anchors_t, anchor_force
  use base_agreement, only: agree
  use base_comm, only: rank_count, this_rank
  use base_error, only: error_t
  use base_kinds, only: wp, i8
  use base_system, only: seconds_of_both
  use constraint, only: follow, fold_force
  use contact_assembly, only: contact_work_t, new_contact_work, find_contact, contact_cliques, &
                              map_contact, add_contact, CLIQUES
  use csr, only: block_matrix_t, clique_t, new_pattern, element_map, set_zero, sum_diagonal
  use csr_fold, only: fold_t, tied_cliques, new_fold, fold_matrix
  use dynamics_type, only: acceleration, HHT
  use element_sweep, only: sweep_t, form_block
  use element_type, only: NB
  use external_load, only: map_t, external_force
  use inertia, only: mass_t, find_masses, driven_marks, add_inertia
  use mesh, only: is_rigid
  use model, only: model_t, state_t
  implicit none
  private
  public :: assembler_t, sweep_t, new_assembler, set_aside, take_back, form, free_part, full_vector

  type :: assembler_t
    type(block_matrix_t) :: k            !! tangent: the part of this rank
    !> (rank_count() + 1, nblock) rank r forms elements first(r) + 1 to first(r + 1) of a block.
    integer, allocatable :: first(:, :)
    integer :: rank = 1                  !! number of this rank
    logical :: new_pattern = .false.   !! the pattern of k has changed since its last analysis
    type(contact_work_t), allocatable :: contact(:)
    type(map_t), allocatable :: map(:)
    type(fold_t) :: fold                 !! folds slaves into their masters
    real(wp), allocatable :: f_int(:, :) !! (3, nnode) internal force [F]
    real(wp), allocatable :: f_contact(:, :) !! (3, nnode) contact, a part of f_int [F]
    real(wp), allocatable :: f_ext(:, :) !! (3, nnode) external force [F]
    type(mass_t), allocatable :: mass(:) !! allocated once inertia acts
    real(wp), allocatable :: f_inert(:, :) !! (3, nnode) inertia, a part of f_int [F]
    type(anchors_t) :: anchors           !! anchors of bodies that contact does not hold
    !> Wall and processor time [s] of the sweeps since the times were last reset (after each
    !! solve), and the part of it that contact takes: search, pattern, forces and tangent.
    real(wp) :: seconds(2) = 0.0_wp, contact_seconds(2) = 0.0_wp
  end type assembler_t

contains

  !> Allocate arrays, pattern and maps; a symmetric matrix has the upper blocks only.
  subroutine new_assembler(asm, model, symmetric, error)
    type(assembler_t), intent(out) :: asm
    type(model_t), intent(in) :: model
    logical, intent(in) :: symmetric
    type(error_t), allocatable, intent(out) :: error

    call new_contact_work(model, asm%contact)
    call divide_elements(model, asm%first)
    asm%rank = this_rank()
    allocate (asm%f_int(3, model%mesh%nnode), asm%f_ext(3, model%mesh%nnode))
    allocate (asm%f_inert(3, model%mesh%nnode), asm%f_contact(3, model%mesh%nnode), source=0.0_wp)
    call set_pattern(asm, model, symmetric, 0, error)
  end subroutine new_assembler

  !> Set the contact, the masses and the anchors of the current step aside while a new assembler
  !! replaces the present one.
  subroutine set_aside(asm, kept)
    type(assembler_t), intent(inout) :: asm
    type(assembler_t), intent(out) :: kept

    call move_alloc(asm%contact, kept%contact)
    call move_alloc(asm%mass, kept%mass)
    kept%anchors = asm%anchors
  end subroutine set_aside

  !> Take what was set aside back into a new assembler.
  subroutine take_back(asm, model, step, kept, error)
    type(assembler_t), intent(inout) :: asm
    type(model_t), intent(in) :: model
    integer, intent(in) :: step          !! number of the current step
    type(assembler_t), intent(inout) :: kept
    type(error_t), allocatable, intent(out) :: error
    logical :: symmetric

    if (.not. allocated(kept%contact)) return ! there was no assembler
    call move_alloc(kept%contact, asm%contact)
    call move_alloc(kept%mass, asm%mass)
    asm%anchors = kept%anchors
    symmetric = asm%k%symmetric ! a copy, because set_pattern replaces asm%k
    call set_pattern(asm, model, symmetric, step, error)
  end subroutine take_back

  !> Divide the elements of each block into equal parts of whole batches, one for each rank.
  subroutine divide_elements(model, first)
    type(model_t), intent(in) :: model
    integer, allocatable, intent(out) :: first(:, :)
    integer(i8) :: nbatch
    integer :: b, nelem, r

    allocate (first(rank_count() + 1, size(model%mesh%block)))
    do b = 1, size(first, 2)
      nelem = merge(0, model%mesh%block(b)%nelem, is_rigid(model%mesh%block(b)))
      nbatch = (nelem + NB - 1)/NB
      first(:, b) = [(min(nelem, NB*int(nbatch*r/rank_count())), r=0, rank_count())]
    end do
  end subroutine divide_elements

  !> The first and the last element of a block that this rank forms.
  pure function own_elements(asm, b) result(range)
    type(assembler_t), intent(in) :: asm
    integer, intent(in) :: b
    integer :: range(2)

    range = [asm%first(asm%rank, b) + 1, asm%first(asm%rank + 1, b)]
  end function own_elements

  !> Find the pattern of the elements and of the active contact pairs of a step.
  subroutine set_pattern(asm, model, symmetric, step, error)
    type(assembler_t), intent(inout) :: asm
    type(model_t), intent(in) :: model
    logical, intent(in) :: symmetric
    integer, intent(in) :: step
    type(error_t), allocatable, intent(out) :: error
    type(clique_t), allocatable :: clique(:)
    integer :: b, n, nblock, own(2)

    nblock = size(model%mesh%block)
    allocate (clique(nblock + CLIQUES*size(asm%contact) + 2))
    do b = 1, nblock
      own = own_elements(asm, b)
      allocate (clique(b)%conn, source=model%mesh%block(b)%conn(:, own(1):own(2)))
    end do
    n = size(clique) - 1
    call contact_cliques(asm%contact, model, step, clique(nblock + 1:n - 1))
    associate (list => model%mesh%constraint) ! every rank moves all slaves
      if (rank_count() > 1 .and. list%n > 0) then
        clique(n)%conn = reshape(list%slave(:list%n), [1, list%n])
      else
        allocate (clique(n)%conn(1, 0))
      end if
    end associate
    call tied_cliques(model%mesh%constraint, model%mesh%nnode, clique(:n), clique(n + 1))
    call new_pattern(asm%k, model%mesh%nnode, clique, symmetric, error)
    call agree(error)
    if (allocated(error)) return
    asm%k%shared = rank_count() > 1
    if (.not. allocated(asm%map)) allocate (asm%map(nblock))
    do b = 1, nblock
      if (is_rigid(model%mesh%block(b))) cycle
      n = model%mesh%block(b)%nen
      if (.not. allocated(asm%map(b)%at)) then
        allocate (asm%map(b)%at(n, n, model%mesh%block(b)%nelem), source=0)
      end if
      own = own_elements(asm, b)
      call element_map(asm%k, model%mesh%block(b)%conn(:, own(1):own(2)), &
                       asm%map(b)%at(:, :, own(1):own(2)), error)
      call agree(error)
      if (allocated(error)) return
    end do
    call map_contact(asm%contact, model, asm%k)
    call new_fold(model%mesh%constraint, asm%k, asm%fold, error)
    call agree(error)
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
      call form_block(model, state, b, asm%first(:, b), asm%map(b)%at, asm%k, asm%f_int, sweep)
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
      call sum_diagonal(asm%k)
    end if
    asm%seconds = asm%seconds + seconds_of_both() - start
  end subroutine form

  !> Add the inertial forces and their tangent in a dynamic analysis.
  !!
  !! The equations of HHT are divided by 1 + alpha. At free dofs, the inertial forces are therefore
  !! M a/(1 + alpha) - alpha/(1 + alpha) f, where f is the static force at the start of the step.
  !! The force of a support is M a plus the static force at the end of the step.
  subroutine form_inertia(asm, model, state)
    type(assembler_t), intent(inout) :: asm
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    real(wp), allocatable :: acc(:, :)
    logical, allocatable :: driven(:, :)
    integer :: b

    asm%f_inert = 0.0_wp
    if (.not. state%dynamics%on) return
    if (.not. allocated(asm%mass)) call find_masses(model, state%dynamics, asm%mass)
    if (.not. state%dt > 0.0_wp) return ! a step without TIME is static
    associate (alpha => state%dynamics%alpha)
      if (state%dynamics%method == HHT) then
        where (model%eq > 0) asm%f_inert = -alpha/(1.0_wp + alpha)*state%dynamics%static
      end if
    end associate
    allocate (driven, source=driven_marks(model))
    allocate (acc, source=acceleration(state%dynamics, state%u - state%u_step, driven))
    call follow(model%mesh%constraint, acc)
    do b = 1, size(model%mesh%block)
      if (.not. allocated(asm%mass(b)%m)) cycle
      call add_inertia(model%mesh%block(b), asm%mass(b), state%dynamics, acc, driven, &
                       asm%map(b)%at, asm%k, asm%f_inert)
    end do
    ! slaves have no equations, so their forces go to the masters: before supports are scaled, and
    ! because the static forces that the next step may need are found without slaves
    call fold_force(model%mesh%constraint, asm%f_inert)
    if (state%dynamics%method == HHT) then
      where (model%eq == 0) asm%f_inert = (1.0_wp + state%dynamics%alpha)*asm%f_inert
    end if
    asm%f_int = asm%f_int + asm%f_inert
  end subroutine form_inertia

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
