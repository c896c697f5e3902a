!> Times the element kernels: residual and tangent, microseconds an element on one core, beside
!! what dgemm reaches here. Results of many elements are summed so that nothing can be left out.
program bench_kernel
  use base_cpu, only: vector_level
  use base_error, only: error_t
  use base_kinds, only: wp, i8
  use basis_type, only: basis_t
  use blas_choice, only: prepare_blas
  use blas_threads, only: blas_kernel, set_threads
  use element_table, only: load_elements
  use element_type, only: element_t, cell_t, rule_t, topology_t, form_report_t, NB
  use lapack, only: dgemm
  use material_table, only: load_materials
  use material_type, only: material_t, MAX_PROP, constant_error_t
  use solid_form, only: history_length
  implicit none

  type(element_t), allocatable :: element(:)
  type(material_t), allocatable :: material(:)
  !> The best of many short samples: what others do on the machine must not count.
  integer, parameter :: SAMPLES = 60
  integer(i8), parameter :: SAMPLE_TIME = 3000000_i8 ! [ns]
  type(error_t), allocatable :: error
  real(wp) :: check

  check = 0.0_wp
  call prepare_blas()
  call set_threads(1, error)
  if (allocated(error)) error stop 'no memory for the linear algebra'
  print '(a, i0, 2a)', ' element kernels, one thread; x86-64 level ', vector_level(), &
    ', BLAS kernel ', blas_kernel()
  call load_elements(element)
  call load_materials(material)
  call time_dgemm(500)
  call time_dgemm(27)
  print '(a)', ' element    nodes  points   law         batch of 8 [us]   single [us]'
  call time_element('Q1', [1, 1, 1])
  call time_element('Q1E9', [1, 1, 1])
  call time_element('Q2', [2, 2, 2])
  call time_element('IGA', [2, 2, 2])
  call time_element('IGA', [3, 3, 3])
  call time_element('Q1N', [2, 2, 1])
  call time_element('Q1N', [3, 3, 1])
  call time_element('Q1E9N', [2, 2, 1])
  call time_element('Q2N', [2, 2, 2])
  call time_element('TET10', [2, 2, 2])
  print '(a, es10.2)', ' checksum', check

contains

  !> One type of element with both laws.
  subroutine time_element(name, degree)
    character(*), intent(in) :: name
    integer, intent(in) :: degree(3)
    type(cell_t) :: cell
    type(basis_t) :: basis
    real(wp), allocatable :: xr(:, :), u(:, :)
    integer :: e, m

    do e = 1, size(element)
      if (element(e)%name /= name) cycle
      cell%degree = degree
      call tabulate(element(e), cell, basis)
      call place(name, degree, basis%nen, xr)
      allocate (u(3, basis%nen))
      call random_number(u)
      u = 0.05_wp*(u - 0.5_wp)
      do m = 1, size(material)
        print '(1x, a, t13, 2i7, 3x, a, t43, a, f12.3)', trim(name), basis%nen, basis%nq, &
          material(m)%name(:10), batch_time(element(e), material(m), basis, xr, u), &
          single_time(element(e), material(m), basis, xr, u)
      end do
    end do
  end subroutine time_element

  !> Microseconds of form.
  function single_time(row, law, basis, xr, u) result(t)
    type(element_t), intent(in) :: row
    type(material_t), intent(in) :: law
    type(basis_t), intent(in) :: basis
    real(wp), intent(in) :: xr(:, :), u(:, :)
    type(constant_error_t) :: wrong
    real(wp) :: t
    real(wp) :: prop(MAX_PROP), r(3, basis%nen), k(3*basis%nen, 3*basis%nen)
    real(wp), allocatable :: h_old(:), h_new(:)
    type(form_report_t) :: report
    integer(i8) :: start
    integer :: n, sample
    real(wp) :: du(3, basis%nen)

    du = 0.0_wp
    allocate (h_old(history_length(basis%nen, row%nmode)))
    allocate (h_new, mold=h_old)
    h_old = 0.0_wp
    call law%set(law%example(:law%nvalue), prop, wrong)
    t = huge(t)
    do sample = 1, SAMPLES
      n = 0
      start = clock()
      do while (clock() - start < SAMPLE_TIME)
        call row%form(basis, law, prop, xr, u, du, 0.0_wp, h_old, h_new, r, k, report)
        n = n + 1
        check = check + k(1, 1) + merge(0.0_wp, huge(1.0_wp), report%ok)
      end do
      t = min(t, 1.0e-3_wp*real(clock() - start, wp)/n)
    end do
  end function single_time

  !> Microseconds an element of form_batch, or a dash.
  function batch_time(row, law, basis, xr, u) result(text)
    type(element_t), intent(in) :: row
    type(material_t), intent(in) :: law
    type(basis_t), intent(in) :: basis
    real(wp), intent(in) :: xr(:, :), u(:, :)
    type(constant_error_t) :: wrong
    character(12) :: text
    real(wp) :: prop(MAX_PROP), x8(NB, 3, basis%nen), u8(NB, 3, basis%nen), r(NB, 3, basis%nen)
    real(wp), allocatable :: k(:, :, :, :, :), h_old(:, :), h_new(:, :)
    type(form_report_t) :: report(NB)
    integer(i8) :: start
    integer :: n, e, sample
    real(wp) :: du(NB, 3, basis%nen), t

    text = '           -'
    if (.not. (associated(row%form_batch) .and. associated(law%moduli))) return
    du = 0.0_wp
    allocate (k(NB, 3, 3, basis%nen, basis%nen))
    allocate (h_old(history_length(basis%nen, row%nmode), NB))
    allocate (h_new, mold=h_old)
    h_old = 0.0_wp
    call law%set(law%example(:law%nvalue), prop, wrong)
    do e = 1, NB
      x8(e, :, :) = xr
      u8(e, :, :) = u*(0.1_wp*e)
    end do
    t = huge(t)
    do sample = 1, SAMPLES
      n = 0
      start = clock()
      do while (clock() - start < SAMPLE_TIME)
        call row%form_batch(basis, law, prop, x8, u8, du, 0.0_wp, h_old, h_new, r, k, report)
        n = n + NB
        check = check + k(1, 1, 1, 1, 1) + merge(0.0_wp, huge(1.0_wp), all(report%ok))
      end do
      t = min(t, 1.0e-3_wp*real(clock() - start, wp)/n)
    end do
    write (text, '(f12.3)') t
  end function batch_time

  !> Functions at the points of the usual rule.
  subroutine tabulate(row, cell, basis)
    type(element_t), intent(in) :: row
    type(cell_t), intent(in) :: cell
    type(basis_t), intent(out) :: basis
    type(rule_t) :: rule
    type(topology_t) :: topology
    real(wp), allocatable :: shp(:)
    integer :: q

    call row%rule(cell, 0, 0, rule)
    call row%topology(cell, topology)
    basis%nen = topology%nen
    basis%nq = rule%nq
    basis%nmode = row%nmode
    basis%wgt = rule%wgt
    allocate (basis%shp(basis%nen, basis%nq), basis%dshp(3, basis%nen, basis%nq), shp(basis%nen))
    allocate (basis%mode(3, basis%nmode, basis%nq), basis%dshp0(3, basis%nen))
    do q = 1, basis%nq
      call row%functions(cell, rule%xi(:, q), basis%shp(:, q), basis%dshp(:, :, q))
      if (row%nmode > 0) call row%modes(rule%xi(:, q), basis%mode(:, :, q))
    end do
    call row%functions(cell, [0.0_wp, 0.0_wp, 0.0_wp], shp, basis%dshp0)
  end subroutine tabulate

  !> Node positions of the parent cell, slightly sheared.
  subroutine place(name, degree, nen, x)
    character(*), intent(in) :: name
    integer, intent(in) :: degree(3), nen
    real(wp), allocatable, intent(out) :: x(:, :)
    real(wp), parameter :: CORNERS(2, 4) = reshape([-1.0_wp, -1.0_wp, 1.0_wp, -1.0_wp, &
      1.0_wp, 1.0_wp, -1.0_wp, 1.0_wp], [2, 4])
    integer :: i, j, k, a

    allocate (x(3, nen))
    a = 0
    select case (name)
    case ('Q1', 'Q1E9')
      x(:2, :4) = CORNERS
      x(3, :4) = -1.0_wp
      x(:2, 5:) = CORNERS
      x(3, 5:) = 1.0_wp
    case ('TET10')
      x = 0.0_wp
      x(1, [2, 5, 6, 8, 9, 10]) = [1.0_wp, 0.5_wp, 0.5_wp, 0.0_wp, 0.5_wp, 0.0_wp]
      x(2, [3, 6, 7, 10]) = [1.0_wp, 0.5_wp, 0.5_wp, 0.5_wp]
      x(3, [4, 8, 9, 10]) = [1.0_wp, 0.5_wp, 0.5_wp, 0.5_wp]
    case default ! tensor planes from zeta = -1 up; enriched: Lagrange planes follow
      do k = 0, degree(3)
        if (k > 0 .and. (name == 'Q1N' .or. name == 'Q1E9N')) then
          x(:2, a + 1:) = CORNERS
          x(3, a + 1:) = 1.0_wp
          exit
        end if
        do j = 0, degree(2)
          do i = 0, degree(1)
            a = a + 1
            x(:, a) = 2.0_wp*[i, j, k]/degree - 1.0_wp
          end do
        end do
      end do
    end select
    x(1, :) = x(1, :) + 0.1_wp*x(2, :)
  end subroutine place

  !> GFLOP/s of dgemm on square matrices.
  subroutine time_dgemm(n)
    integer, intent(in) :: n
    real(wp), allocatable :: a(:, :), b(:, :), c(:, :)
    integer(i8) :: start, calls
    real(wp) :: best
    integer :: sample

    allocate (a(n, n), b(n, n), c(n, n))
    call random_number(a)
    b = a
    c = 0.0_wp
    best = 0.0_wp
    do sample = 1, SAMPLES
      calls = 0
      start = clock()
      do while (clock() - start < SAMPLE_TIME)
        call dgemm('N', 'T', n, n, n, 1.0_wp, a, n, b, n, 0.0_wp, c, n)
        calls = calls + 1
      end do
      best = max(best, 2.0_wp*real(n, wp)**3*calls/(clock() - start))
    end do
    check = check + c(1, 1)
    print '(a, i4, a, f8.1, a)', ' dgemm', n, ':', best, ' GFLOP/s'
  end subroutine time_dgemm

  !> Nanoseconds.
  function clock() result(t)
    integer(i8) :: t, rate

    call system_clock(t, rate)
    t = t*(1000000000_i8/rate)
  end function clock

end program bench_kernel
