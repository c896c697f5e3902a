!> Forces and tangents of the elements of one block, added to those of the model.
!!
!! The elements are processed in groups. First the threads form the elements of a group; then one
!! thread adds the forces, and each thread adds the rows of the tangent that belong to its share of
!! the nodes. As all sums are formed in the order of the elements, the results have the same bits
!! for any number of threads.
module element_sweep
  use base_comm, only: gather_blocks, this_rank
  use base_kinds, only: wp
  use base_threads, only: team_size, this_thread, thread_count
  use csr, only: block_matrix_t, add_element, add_batch, share_rows
  use element_type, only: form_report_t, NB
  use external_load, only: scatter_force
  use model, only: model_t, state_t
  implicit none
  private
  public :: sweep_t, form_block

  !> The result of one sweep over the elements.
  type :: sweep_t
    logical :: ok = .true.
    integer :: block = 0, elem = 0       !! the first element that failed
    integer :: negative = 0              !! negative eigenvalues of condensed enhanced modes
    real(wp) :: enhanced = 0.0_wp        !! energy of the enhanced residuals [F L]
    real(wp) :: rounding = 0.0_wp        !! sum of |f||u| over elements [F L]
    real(wp) :: largest = 0.0_wp         !! largest nodal force from one element [F]
  end type sweep_t

contains

  !> Form the elements of block b and add their forces and tangents. The trial history is filled.
  !! After an element that failed, forces and tangent are incomplete.
  subroutine form_block(model, state, b, first, map, k, f, sweep)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    integer, intent(in) :: b
    integer, intent(in) :: first(:)          !! rank r forms elements first(r) + 1 to first(r + 1)
    integer, intent(in) :: map(:, :, :)      !! (nen, nen, nelem) positions of the blocks in k
    type(block_matrix_t), intent(inout) :: k
    real(wp), intent(inout) :: f(:, :)       !! (3, nnode) internal force [F]
    type(sweep_t), intent(inout) :: sweep
    real(wp), allocatable :: found(:, :)     !! (3*nen + 3, nelem), see packed
    integer :: own(2)
    logical :: batches

    own = [first(this_rank()) + 1, first(this_rank() + 1)]
    associate (block => model%mesh%block(b), mat => model%material(model%mesh%block(b)%material))
      ! Elements that are not formed because an earlier one failed count as failed on other ranks.
      if (k%shared) allocate (found(3*block%nen + 3, block%nelem), source=0.0_wp)
      batches = associated(block%row%form_batch) .and. associated(mat%row%moduli) .and. &
                size(block%basis) == 1
    end associate
    if (batches) then
      call form_batches(model, state, b, own, map, k, f, found, sweep)
    else
      call form_elements(model, state, b, own, map, k, f, found, sweep)
    end if
    if (k%shared) call add_found(model, state, b, first, found, f, sweep)
  end subroutine form_block

  !> Number of elements or batches that are formed together: one if there is only one thread,
  !! otherwise so many that the threads seldom wait for each other, within a limit of memory.
  integer function group_size(bytes)
    integer, intent(in) :: bytes            !! memory of the tangent of one of them
    integer, parameter :: MEMORY = 2**19    !! for each thread, if one of them does not need more
    integer, parameter :: FEWEST = 2

    group_size = 1
    if (thread_count() > 1) group_size = thread_count()*max(FEWEST, MEMORY/bytes)
  end function group_size

  !> Form the elements own(1) to own(2) of a block one by one.
  subroutine form_elements(model, state, b, own, map, k, f, found, sweep)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    integer, intent(in) :: b, own(2)
    integer, intent(in) :: map(:, :, :)
    type(block_matrix_t), intent(inout) :: k
    real(wp), intent(inout) :: f(:, :)
    real(wp), allocatable, intent(inout) :: found(:, :)
    type(sweep_t), intent(inout) :: sweep
    real(wp), allocatable :: r(:, :, :), tangent(:, :, :)
    type(form_report_t), allocatable :: report(:)
    integer, allocatable :: row(:)
    integer :: e0, i, n, nen, nrow, room

    nen = model%mesh%block(b)%nen
    room = group_size(8*(3*nen)**2)
    allocate (r(3, nen, room), tangent(3*nen, 3*nen, room), report(room))
    !$omp parallel default(shared) private(row, e0, i, n, nrow)
    allocate (row(nen))
    do e0 = own(1) - 1, own(2) - 1, room
      n = min(room, own(2) - e0)
      !$omp do schedule(dynamic)
      do i = 1, n
        call form_one(model, state, b, e0 + i, r(:, :, i), tangent(:, :, i), report(i))
      end do
      !$omp end do
      !$omp single
      call add_forces(model, state, b, e0, report(:n), r(:, :, :n), f, found, sweep)
      !$omp end single nowait
      if (.not. all(report(:n)%ok)) exit
      do i = 1, n
        call share_rows(model%mesh%block(b)%conn(:, e0 + i), this_thread(), team_size(), row, nrow)
        call add_element(k, map(:, :, e0 + i), tangent(:, :, i), row(:nrow))
      end do
      !$omp barrier
    end do
    !$omp end parallel
  end subroutine form_elements

  !> Form element e of a block.
  subroutine form_one(model, state, b, e, r, tangent, report)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    integer, intent(in) :: b, e
    real(wp), intent(out) :: r(:, :), tangent(:, :)
    type(form_report_t), intent(out) :: report
    real(wp), dimension(3, size(r, 2)) :: xr, u, du

    associate (block => model%mesh%block(b), mat => model%material(model%mesh%block(b)%material), &
               h => state%history(b))
      xr = model%mesh%xr(:, block%conn(:, e))
      u = state%u(:, block%conn(:, e))
      du = u - state%u_base(:, block%conn(:, e))
      call block%row%form(block%basis(block%ibasis(e)), mat%row, mat%prop, xr, u, du, &
                          state%scale, h%iter(:, e), h%trial(:, e), r, tangent, report)
    end associate
  end subroutine form_one

  !> Form the elements own(1) to own(2) of a block, NB at a time.
  subroutine form_batches(model, state, b, own, map, k, f, found, sweep)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    integer, intent(in) :: b, own(2)
    integer, intent(in) :: map(:, :, :)
    type(block_matrix_t), intent(inout) :: k
    real(wp), intent(inout) :: f(:, :)
    real(wp), allocatable, intent(inout) :: found(:, :)
    type(sweep_t), intent(inout) :: sweep
    real(wp), allocatable :: r(:, :, :), tangent(:, :, :, :, :, :)
    type(form_report_t), allocatable :: report(:)
    integer :: e0, e1, i, n, nen, room

    nen = model%mesh%block(b)%nen
    room = group_size(8*NB*(3*nen)**2)
    allocate (r(3, nen, NB*room), tangent(NB, 3, 3, nen, nen, room), report(NB*room))
    !$omp parallel default(shared) private(e0, e1, i, n)
    do e0 = own(1) - 1, own(2) - 1, NB*room
      n = min(NB*room, own(2) - e0)
      !$omp do schedule(dynamic)
      do i = 1, n, NB
        e1 = min(i + NB - 1, n)
        call form_batch(model, state, b, e0 + i, e0 + e1, r(:, :, i:e1), &
                        tangent(:, :, :, :, :, (i + NB - 1)/NB), report(i:e1))
      end do
      !$omp end do
      !$omp single
      call add_forces(model, state, b, e0, report(:n), r(:, :, :n), f, found, sweep)
      !$omp end single nowait
      if (.not. all(report(:n)%ok)) exit
      do i = 1, n, NB
        e1 = min(i + NB - 1, n)
        call add_batch(k, model%mesh%block(b)%conn(:, e0 + i:e0 + e1), map(:, :, e0 + i:e0 + e1), &
                       tangent(:, :, :, :, :, (i + NB - 1)/NB), this_thread(), team_size())
      end do
      !$omp barrier
    end do
    !$omp end parallel
  end subroutine form_batches

  !> Form the elements e0 to e1 of a block, at most NB. A batch that is not full repeats its last
  !! element.
  subroutine form_batch(model, state, b, e0, e1, r, tangent, report)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    integer, intent(in) :: b, e0, e1
    real(wp), intent(out) :: r(:, :, :)              !! (3, nen, e1 - e0 + 1)
    real(wp), intent(out) :: tangent(:, :, :, :, :)  !! see element_batch_i
    type(form_report_t), intent(out) :: report(:)
    real(wp), dimension(NB, 3, size(r, 2)) :: xr, u, du, f
    real(wp), dimension(size(state%history(b)%iter, 1), NB) :: h_old, h_new
    type(form_report_t) :: reports(NB)
    integer :: e, i, lane

    associate (block => model%mesh%block(b), mat => model%material(model%mesh%block(b)%material), &
               h => state%history(b))
      do lane = 1, NB
        e = min(e0 + lane - 1, e1)
        do i = 1, block%nen
          xr(lane, :, i) = model%mesh%xr(:, block%conn(i, e))
          u(lane, :, i) = state%u(:, block%conn(i, e))
          du(lane, :, i) = u(lane, :, i) - state%u_base(:, block%conn(i, e))
        end do
        h_old(:, lane) = h%iter(:, e)
      end do
      call block%row%form_batch(block%basis(1), mat%row, mat%prop, xr, u, du, state%scale, &
                                h_old, h_new, f, tangent, reports)
      do lane = 1, e1 - e0 + 1
        r(:, :, lane) = f(lane, :, :)
        report(lane) = reports(lane)
        if (report(lane)%ok) h%trial(:, e0 + lane - 1) = h_new(:, lane)
      end do
    end associate
  end subroutine form_batch

  !> Add the forces and reports of the elements e0 + 1, e0 + 2, ..., up to the first that failed. If
  !! several ranks form elements, they are stored instead.
  subroutine add_forces(model, state, b, e0, report, r, f, found, sweep)
    type(model_t), intent(in) :: model
    type(state_t), intent(in) :: state
    integer, intent(in) :: b, e0
    type(form_report_t), intent(in) :: report(:) !! (n)
    real(wp), intent(in) :: r(:, :, :)           !! (3, nen, n)
    real(wp), intent(inout) :: f(:, :)
    real(wp), allocatable, intent(inout) :: found(:, :)
    type(sweep_t), intent(inout) :: sweep
    integer :: e, i

    do i = 1, size(report)
      e = e0 + i
      if (allocated(found)) then
        if (.not. report(i)%ok) return
        found(:, e) = packed(report(i), r(:, :, i))
      else
        associate (node => model%mesh%block(b)%conn(:, e))
          call note(sweep, report(i), b, e, r(:, :, i), state%u(:, node))
          if (.not. sweep%ok) return
          call scatter_force(node, r(:, :, i), f)
        end associate
      end if
    end do
  end subroutine add_forces

  !> The forces of an element, whether it was formed, and its report.
  pure function packed(report, r) result(list)
    type(form_report_t), intent(in) :: report
    real(wp), intent(in) :: r(:, :)
    real(wp) :: list(size(r) + 3)

    list = [reshape(r, [size(r)]), 1.0_wp, real(report%negative, wp), report%enhanced]
  end function packed

  !> Send the results of each rank to all ranks, and add them as add_forces does on one rank. All
  !! ranks get the history of all elements.
  subroutine add_found(model, state, b, first, found, f, sweep)
    type(model_t), intent(in) :: model
    type(state_t), intent(inout) :: state
    integer, intent(in) :: b, first(:)
    real(wp), intent(inout), contiguous :: found(:, :)
    real(wp), intent(inout) :: f(:, :)
    type(sweep_t), intent(inout) :: sweep
    type(form_report_t) :: report
    real(wp) :: r(3, model%mesh%block(b)%nen)
    integer :: e, n

    call gather_blocks(found, first)
    if (size(state%history(b)%trial, 1) > 0) call gather_blocks(state%history(b)%trial, first)
    n = size(r)
    do e = 1, size(found, 2)
      report%ok = found(n + 1, e) > 0.0_wp
      report%negative = nint(found(n + 2, e))
      report%enhanced = found(n + 3, e)
      r = reshape(found(:n, e), shape(r))
      associate (node => model%mesh%block(b)%conn(:, e))
        call note(sweep, report, b, e, r, state%u(:, node))
        if (.not. sweep%ok) return
        call scatter_force(node, r, f)
      end associate
    end do
  end subroutine add_found

  !> Add the report of an element to the results of the sweep.
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

end module element_sweep
