!> Acceleration of an iteration whose tangent lacks a part of the derivative (Anderson's method).
!!
!! With the increment dx_k that the linear system gives after k increments, and the increments s_j
!! that were taken, the next one is
!!
!!   s_k = dx_k - sum_j c_j (dx_(j+1) - dx_j + s_j),
!!
!! where c minimises |dx_k - sum_j c_j (dx_(j+1) - dx_j)| over the last DEPTH increments. If the
!! increments decrease quadratically, c is so small that they remain what they are.
!! Source: Walker and Ni 2011 [bib: walker2011]
module anderson
  use base_kinds, only: wp
  use lapack, only: dgesv
  implicit none
  private
  public :: anderson_t, accelerate, accelerate_slow, forget, restart

  integer, parameter :: DEPTH = 6
  real(wp), parameter :: REGULAR = 1.0e-12_wp !! relative addition to the diagonal of the normal
  !! equations for c

  real(wp), parameter :: FAST = 0.1_wp, SLOWEST = 0.95_wp !! ratios of consecutive increments
  real(wp), parameter :: LONGEST = 10.0_wp !! largest ratio of an accelerated increment to dx_k
  integer, parameter :: MANY = 2           !! number of slow increments before acceleration

  type :: anderson_t
    private
    integer :: slow = 0                    !! number of increments since they decrease slowly
    logical :: failed = .false.
    logical :: accelerated = .false.
    real(wp) :: length = 0.0_wp            !! of the last increment of the linear system [L]
    integer :: known = 0                   !! number of columns of `change` and `taken` in use
    !> (neq, DEPTH) dx_(j+1) - dx_j, the latest first [L].
    real(wp), allocatable :: change(:, :)
    real(wp), allocatable :: taken(:, :)   !! (neq, DEPTH) s_j [L]
    real(wp), allocatable :: last_dx(:)    !! (neq) dx_(k-1), if there is one [L]
  end type anderson_t

contains

  !> Replace the increment of the linear system by the accelerated one.
  subroutine accelerate(past, dx)
    type(anderson_t), intent(inout) :: past
    real(wp), intent(inout) :: dx(:)       !! (neq) [L]
    real(wp), allocatable :: new(:)
    real(wp) :: a(DEPTH, DEPTH), c(DEPTH)
    integer :: i, info, n, pivot(DEPTH)

    if (.not. allocated(past%change)) then
      allocate (past%change(size(dx), DEPTH), past%taken(size(dx), DEPTH))
    end if
    new = dx
    if (allocated(past%last_dx)) then
      n = min(DEPTH, past%known + 1)
      past%known = n
      past%change(:, 2:n) = past%change(:, :n - 1)
      past%change(:, 1) = dx - past%last_dx
      a(:n, :n) = matmul(transpose(past%change(:, :n)), past%change(:, :n))
      do i = 1, n
        a(i, i) = (1.0_wp + REGULAR)*a(i, i)
      end do
      c(:n) = matmul(dx, past%change(:, :n))
      call dgesv(n, 1, a, DEPTH, pivot, c, DEPTH, info)
      if (info == 0) new = dx - matmul(past%change(:, :n) + past%taken(:, :n), c(:n))
    end if
    past%last_dx = dx
    dx = new
    past%taken(:, 2:) = past%taken(:, :DEPTH - 1)
    past%taken(:, 1) = dx
  end subroutine accelerate

  !> The same, but only where the increments of the linear system decrease, and slowly. If one is
  !! longer than that before it, the acceleration has failed, and is given up until `restart`.
  subroutine accelerate_slow(past, dx)
    type(anderson_t), intent(inout) :: past
    real(wp), intent(inout) :: dx(:)       !! (neq) [L]
    real(wp), allocatable :: new(:)
    real(wp) :: length

    length = norm2(dx)
    if (past%failed) return
    if (past%slow > 0) past%failed = length > past%length .and. past%accelerated
    if (length > FAST*past%length .and. length < SLOWEST*past%length) then
      past%slow = past%slow + 1
    else
      call forget(past)
    end if
    past%length = length
    if (past%failed) return
    new = dx
    call accelerate(past, new)
    past%accelerated = past%slow >= MANY .and. norm2(new) <= LONGEST*length
    if (past%accelerated) then
      dx = new
    else
      past%taken(:, 1) = dx
    end if
  end subroutine accelerate_slow

  !> Begin again without earlier increments.
  pure subroutine forget(past)
    type(anderson_t), intent(inout) :: past

    past%known = 0
    past%slow = 0
    past%accelerated = .false.
    past%length = 0.0_wp
    if (allocated(past%last_dx)) deallocate (past%last_dx)
  end subroutine forget

  !> Forget that the acceleration has failed, too.
  pure subroutine restart(past)
    type(anderson_t), intent(inout) :: past

    call forget(past)
    past%failed = .false.
  end subroutine restart

end module anderson
