!> What a contact is not told: the penalty of AUTO, from stiffness and element size.
!!
!!   eps = 125 min over the bodies of E/h,   h^2 the mean area of the surface's elements
!!
!! E is Young's modulus of the body; rigid bodies do not count. With a pressure p the penetration is
!! (p/E) h/125. The constant is that of Corbett and Sauer 2015, section 5.3: eps = 125 E/L, 250 E/L
!! and 500 E/L on blocks with E and elements of length L, L/2 and L/4.
module setup_contact_auto
  use base_kinds, only: wp
  use base_text, only: to_text
  use contact_pair, only: contact_t, surface_t
  use material_type, only: E_MOD
  use mesh, only: mesh_t
  use model, only: model_t
  implicit none
  private
  public :: element_areas, auto_penalty

  real(wp), parameter :: STIFF = 125.0_wp

contains

  !> Reference areas of the elements of a side, and the widths of their nodes' boxes.
  subroutine element_areas(mesh, contact, k, area, width)
    type(mesh_t), intent(in) :: mesh
    type(contact_t), intent(in) :: contact
    integer, intent(in) :: k
    real(wp), allocatable, intent(out) :: area(:), width(:) !! (nelem) [L^2], [L]
    real(wp) :: low(3), high(3)
    integer :: a, e, q

    associate (s => contact%side(k))
      allocate (area(s%nelem), width(s%nelem), source=0.0_wp)
      do e = 1, s%nelem
        low = huge(low)
        high = -huge(high)
        do a = s%first(e), s%first(e + 1) - 1
          low = min(low, mesh%xr(:, s%node(a)))
          high = max(high, mesh%xr(:, s%node(a)))
        end do
        width(e) = norm2(high - low)
        do q = 1, contact%nplain
          area(e) = area(e) + contact%wgt(q)*stretch(mesh, s, e, q)
        end do
      end do
    end associate
  end subroutine element_areas

  !> Area per parent area at point q of element e: R = w N / W, W = sum of w N.
  pure real(wp) function stretch(mesh, s, e, q)
    type(mesh_t), intent(in) :: mesh
    type(surface_t), intent(in) :: s
    integer, intent(in) :: e, q
    real(wp) :: w, total(3), sum_x(3, 3), t(3, 2)
    integer :: a, i, j

    total = 0.0_wp ! N and its derivatives
    sum_x = 0.0_wp
    associate (kind => s%kind(s%ikind(e)))
      do i = 1, kind%nsf
        a = s%first(e) + i - 1
        w = 1.0_wp
        if (allocated(s%w)) w = s%w(a)
        total = total + w*[kind%shp(i, q), kind%dshp(1, i, q), kind%dshp(2, i, q)]
        sum_x(:, 1) = sum_x(:, 1) + w*kind%shp(i, q)*mesh%xr(:, s%node(a))
        do j = 1, 2
          sum_x(:, j + 1) = sum_x(:, j + 1) + w*kind%dshp(j, i, q)*mesh%xr(:, s%node(a))
        end do
      end do
    end associate
    do j = 1, 2
      t(:, j) = (sum_x(:, j + 1) - sum_x(:, 1)*(total(j + 1)/total(1)))/total(1)
    end do
    stretch = norm2([t(2, 1)*t(3, 2) - t(3, 1)*t(2, 2), t(3, 1)*t(1, 2) - t(1, 1)*t(3, 2), &
                     t(1, 1)*t(2, 2) - t(2, 1)*t(1, 2)])
  end function stretch

  !> The penalty [F/L^3] and how it was found.
  subroutine auto_penalty(model, contact, factor, eps, account)
    type(model_t), intent(in) :: model
    type(contact_t), intent(in) :: contact
    real(wp), intent(in) :: factor
    real(wp), intent(out) :: eps
    character(:), allocatable, intent(out) :: account
    real(wp), allocatable :: area(:), width(:)
    real(wp) :: stiffness, h
    integer :: k

    eps = huge(eps)
    do k = 1, 2
      associate (s => contact%side(k))
        if (s%rigid) cycle
        call element_areas(model%mesh, contact, k, area, width)
        h = sqrt(sum(area)/s%nelem)
        stiffness = softest(model, s)
        if (.not. factor*STIFF*stiffness/h < eps) cycle
        eps = factor*STIFF*stiffness/h
        account = 'AUTO: '//to_text(factor*STIFF)//' E/h of '//s%name//', E = ' &
                  //to_text(stiffness)//', h = '//to_text(h)
      end associate
    end do
  end subroutine auto_penalty

  !> The smallest modulus behind a surface [F/L^2].
  pure real(wp) function softest(model, s)
    type(model_t), intent(in) :: model
    type(surface_t), intent(in) :: s
    integer :: e

    softest = huge(softest)
    do e = 1, s%nelem
      softest = min(softest, model%material(model%mesh%block(s%block(e))%material)%prop(E_MOD))
    end do
  end function softest

end module setup_contact_auto
